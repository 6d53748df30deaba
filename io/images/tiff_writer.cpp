// Samples as TIFF, by libtiff.
#include <tiffio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "io/bands/band_tags.h"
#include "io/images.h"
#include "io/images/image_file.h"

namespace gpvc::io {
namespace {

// Registered by GDAL: https://gdal.org/drivers/raster/gtiff.html#internal-nodata-masks
constexpr std::uint32_t kGdalMetadata = 42112;
constexpr std::uint32_t kTile = 256;  ///< edge, pixels

/// The first thing that libtiff complains of.
struct Complaint {
  std::string text;
  static int note(TIFF*, void* user, const char*, const char* format, va_list arguments) {
    Complaint& self = *static_cast<Complaint*>(user);
    char text[400];
    std::vsnprintf(text, sizeof text, format, arguments);
    if (self.text.empty()) self.text = text;
    return 1;
  }
  static int ignore(TIFF*, void*, const char*, const char*, va_list) { return 1; }
};

struct ClosesNew {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using NewTiff = std::unique_ptr<TIFF, ClosesNew>;

/// On a descriptor of its own. BigTIFF where 32-bit offsets may not reach.
NewTiff open_for(const OutputFile& out, double bytes, Complaint& complaint) {
  constexpr double kMostClassic = 4e9;
  const int own = ::dup(out.descriptor());
  if (own < 0) return nullptr;
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(),
                                                                                 &TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), &Complaint::note, &complaint);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), &Complaint::ignore, nullptr);
  NewTiff tiff(TIFFFdOpenExt(own, "", bytes > kMostClassic ? "w8" : "w", options.get()));
  if (!tiff) ::close(own);
  return tiff;
}

void set_size(TIFF& tiff, int width, int height) {
  TIFFSetField(&tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(width));
  TIFFSetField(&tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(height));
  TIFFSetField(&tiff, TIFFTAG_TILEWIDTH, kTile);
  TIFFSetField(&tiff, TIFFTAG_TILELENGTH, kTile);
  TIFFSetField(&tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(&tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  constexpr int kQuick = 3;
  TIFFSetField(&tiff, TIFFTAG_ZIPQUALITY, kQuick);
}

/// Calls fill(x, y, width, height, tile) for each tile, whose part in the picture it fills, and writes it.
template <typename Fill>
bool write_tiles(TIFF& tiff, int width, int height, std::size_t tile_bytes, const Fill& fill) {
  std::vector<std::byte> tile(tile_bytes);
  constexpr int kEdge = static_cast<int>(kTile);
  for (int y = 0; y < height; y += kEdge)
    for (int x = 0; x < width; x += kEdge) {
      std::ranges::fill(tile, std::byte{0});
      fill(x, y, std::min(kEdge, width - x), std::min(kEdge, height - y), tile.data());
      const std::uint32_t number =
          TIFFComputeTile(&tiff, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 0, 0);
      if (TIFFWriteEncodedTile(&tiff, number, tile.data(), static_cast<tmsize_t>(tile.size())) < 0) return false;
    }
  return true;
}

bool write_picture(TIFF& tiff, const Samples& samples, const BandSet& set) {
  set_size(tiff, samples.width, samples.height);
  const auto bands = static_cast<std::uint16_t>(samples.bands);
  const bool colors = samples.bands >= 3 && !set.radiometric && set.composite == std::array<std::size_t, 3>{0, 1, 2};
  const std::uint16_t known = colors ? 3 : 1;
  TIFFSetField(&tiff, TIFFTAG_SAMPLESPERPIXEL, bands);
  TIFFSetField(&tiff, TIFFTAG_BITSPERSAMPLE, static_cast<std::uint16_t>(8 * bytes_of(samples.type)));
  TIFFSetField(&tiff, TIFFTAG_SAMPLEFORMAT, samples.type == SampleType::f32 ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
  TIFFSetField(&tiff, TIFFTAG_PHOTOMETRIC, colors ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  TIFFSetField(&tiff, TIFFTAG_PREDICTOR,
               samples.type == SampleType::f32 ? PREDICTOR_FLOATINGPOINT : PREDICTOR_HORIZONTAL);
  if (bands > known) {
    const std::vector<std::uint16_t> extra(static_cast<std::size_t>(bands - known), EXTRASAMPLE_UNSPECIFIED);
    TIFFSetField(&tiff, TIFFTAG_EXTRASAMPLES, static_cast<std::uint16_t>(extra.size()), extra.data());
  }
  static const TIFFFieldInfo kField = {kGdalMetadata, -1, -1, TIFF_ASCII,
                                       FIELD_CUSTOM,  1,  0,  const_cast<char*>("GDALMetadata")};
  TIFFMergeFieldInfo(&tiff, &kField, 1);
  TIFFSetField(&tiff, kGdalMetadata, metadata_of(set).c_str());
  const std::size_t pixel = samples.pixel_bytes();
  return write_tiles(tiff, samples.width, samples.height, pixel * kTile * kTile,
                     [&](int x, int y, int width, int height, std::byte* tile) {
                       for (int row = 0; row < height; ++row)
                         std::memcpy(tile + pixel * kTile * static_cast<std::size_t>(row), samples.at(x, y + row),
                                     pixel * static_cast<std::size_t>(width));
                     });
}

/// A bit a pixel, 1 where the mask is not 0.
bool write_mask(TIFF& tiff, int width, int height, std::span<const std::uint8_t> mask) {
  set_size(tiff, width, height);
  TIFFSetField(&tiff, TIFFTAG_SUBFILETYPE, FILETYPE_MASK);
  TIFFSetField(&tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MASK);
  TIFFSetField(&tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(&tiff, TIFFTAG_BITSPERSAMPLE, 1);
  return write_tiles(tiff, width, height, kTile * kTile / 8, [&](int x, int y, int columns, int rows, std::byte* tile) {
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i)
        if (mask[pixel_index(x + i, y + j, width)] != 0)
          tile[(kTile * static_cast<std::size_t>(j) + static_cast<std::size_t>(i)) / 8] |= std::byte{0x80} >> i % 8;
  });
}

}  // namespace

void write_tiff(OutputFile& out, const std::filesystem::path& file, const Samples& samples, const BandSet& set,
                std::span<const std::uint8_t> mask) {
  Complaint complaint;
  errno = 0;
  const auto check = [&](bool good) {
    if (good && complaint.text.empty()) return;
    const std::string reason = errno != 0 ? std::strerror(errno) : complaint.text;
    throw OutputError(file, "cannot be written: " + (reason.empty() ? "unknown error" : reason));
  };
  NewTiff tiff = open_for(out, 1.1 * static_cast<double>(samples.bytes.size()), complaint);
  check(tiff != nullptr);
  check(write_picture(*tiff, samples, set) && TIFFWriteDirectory(tiff.get()) != 0);
  if (!mask.empty())
    check(write_mask(*tiff, samples.width, samples.height, mask) && TIFFWriteDirectory(tiff.get()) != 0);
  check(TIFFFlush(tiff.get()) != 0);
}

}  // namespace gpvc::io
