// Georeferenced rasters, as geographic information systems read them: cloud-optimized GeoTIFF, by GDAL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "error.h"
#include "names.h"
#include "progress.h"
#include "samples.h"

namespace gpvc::io {

/// deflate, lzw and zstd are lossless; jpeg and webp are for colours of 8 bits.
enum class RasterCompression { deflate, lzw, zstd, jpeg, webp };
inline constexpr Named<RasterCompression> kRasterCompressionNames[] = {{"deflate", RasterCompression::deflate},
                                                                       {"lzw", RasterCompression::lzw},
                                                                       {"zstd", RasterCompression::zstd},
                                                                       {"jpeg", RasterCompression::jpeg},
                                                                       {"webp", RasterCompression::webp}};
constexpr bool is_lossless(RasterCompression compression) {
  return compression != RasterCompression::jpeg && compression != RasterCompression::webp;
}

/// A raster whose rows run from north to south.
struct RasterInfo {
  int width = 0, height = 0;         ///< pixels
  double west = 0, north = 0;        ///< outer corner of the first pixel, in the reference system
  double pixel_size = 1;             ///< edge of a pixel, in its unit
  std::string wkt{};                 ///< the reference system; empty: none
  std::vector<std::string> bands{};  ///< what each is called; three of u8 are red, green and blue
  SampleType type = SampleType::u8;  ///< of the file
  std::optional<double> nodata{};    ///< what pixels without a value have
  bool mask = false;                 ///< an internal mask says which pixels have a value
  bool mean_overviews = true;        ///< overviews are means of pixels; else each has the value of one pixel
  RasterCompression compression = RasterCompression::deflate;
  int quality = 90;  ///< of jpeg and webp, 1 to 100
  int threads = 0;   ///< that compress; 0: as many as there are cores
  std::vector<std::pair<std::string, std::string>> metadata{};
};

/// Writes a raster row by row, each row once. GDAL needs all of it to lay the file out: until finish(), pixels lie uncompressed in
/// FILE.rows.tif, where empty areas take no space. That is gone afterwards, and so is FILE unless finish() has returned. All
/// functions throw OutputError, the constructor also for what this GDAL cannot write.
/// With static libraries, link gpvc::rasters as well.
class RasterWriter {
 public:
  RasterWriter(std::filesystem::path file, const RasterInfo& info);
  ~RasterWriter();
  RasterWriter(const RasterWriter&) = delete;
  RasterWriter& operator=(const RasterWriter&) = delete;

  /// `samples`: of the rows' pixels one after the other, all bands of a pixel together; values of other types are converted to the
  /// file's and clamped to its range. `mask`: a byte a pixel, 255 or 0; null for a raster without. \pre not while another thread is in
  /// here
  void write_rows(int first_row, int rows, const std::uint8_t* samples, const std::uint8_t* mask = nullptr);
  void write_rows(int first_row, int rows, const std::uint32_t* samples);
  void write_rows(int first_row, int rows, const float* samples, const std::uint8_t* mask = nullptr);

  /// Writes overviews and the file. `progress`: in hundredths.
  void finish(const Progress& progress = {});

 private:
  void write(int first_row, int rows, SampleType type, const void* samples, const std::uint8_t* mask);
  std::filesystem::path file_;
  RasterInfo info_;
  void* raster_ = nullptr;  ///< the module's
};

}  // namespace gpvc::io
