// Rasters by GDAL: rows go to a plain tiled GeoTIFF, which GDAL's driver of cloud-optimized ones then copies.
#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include "io/rasters/raster_module.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

constexpr int kBlock = 256;  // of the rows' file

/// What GDAL says in this thread goes to the caller rather than to the terminal.
class Quiet {
 public:
  Quiet() {
    CPLPushErrorHandlerEx(hear, this);
    CPLErrorReset();
  }
  ~Quiet() { CPLPopErrorHandler(); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
  bool failed() const { return !first_.empty(); }
  /// With the first failure, in a line: those that follow tell that it came to that.
  std::string message(const char* what) const {
    std::string text = first_;
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    return std::string(what) + (text.empty() ? "" : ": " + text);
  }

 private:
  static void CPL_STDCALL hear(CPLErr kind, CPLErrorNum, const char* text) {
    auto& quiet = *static_cast<Quiet*>(CPLGetErrorHandlerUserData());
    if (kind >= CE_Failure && quiet.first_.empty()) quiet.first_ = text;
  }
  std::string first_;
};

/// An option of GDAL as long as it lives, in this thread.
class Option {
 public:
  Option(const char* name, const char* value) : name_(name) { CPLSetThreadLocalConfigOption(name, value); }
  ~Option() { CPLSetThreadLocalConfigOption(name_, nullptr); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

 private:
  const char* name_;
};

class Options {
 public:
  Options() = default;
  ~Options() { CSLDestroy(list_); }
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;
  void set(const char* name, const std::string& value) { list_ = CSLSetNameValue(list_, name, value.c_str()); }
  char** list() const { return list_; }

 private:
  char** list_ = nullptr;
};

struct ClosesDataset {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<void, ClosesDataset>;

struct Raster {
  fs::path file, rows_file;
  RasterInfo info;
  Dataset rows;
  bool complete = false;
};

/// The two drivers alone: plugins of others are not looked for.
void register_drivers() {
  static std::once_flag once;
  std::call_once(once, [] {
    GDALRegister_GTiff();
    GDALRegister_MEM();
    GDALRegister_COG();
    // Rows are written once and read once; by itself GDAL keeps as much of them as a twentieth of the machine's memory.
    constexpr GIntBig kCacheBytes = 128 << 20;
    if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr) == nullptr) GDALSetCacheMax64(kCacheBytes);
  });
}

GDALDataType data_type(SampleType type) {
  constexpr std::array kTypes{GDT_Byte, GDT_UInt16, GDT_UInt32, GDT_Float32};
  return kTypes[static_cast<std::size_t>(type)];
}

const char* compression_name(RasterCompression compression) {
  constexpr std::array kNames{"DEFLATE", "LZW", "ZSTD", "JPEG", "WEBP"};
  return kNames[static_cast<std::size_t>(compression)];
}

/// What is set of a raster before its rows are written.
bool describe(void* dataset, const RasterInfo& info) {
  std::array<double, 6> place{info.west, info.pixel_size, 0, info.north, 0, -info.pixel_size};
  if (GDALSetGeoTransform(dataset, place.data()) != CE_None) return false;
  if (!info.wkt.empty()) {
    const std::unique_ptr<void, decltype(&OSRDestroySpatialReference)> system(OSRNewSpatialReference(nullptr),
                                                                              &OSRDestroySpatialReference);
    std::string wkt = info.wkt;
    char* text = wkt.data();
    if (OSRImportFromWkt(system.get(), &text) != OGRERR_NONE) return false;
    OSRSetAxisMappingStrategy(system.get(), OAMS_TRADITIONAL_GIS_ORDER);
    if (GDALSetSpatialRef(dataset, system.get()) != CE_None) return false;
  }
  for (const auto& [name, value] : info.metadata)
    if (GDALSetMetadataItem(dataset, name.c_str(), value.c_str(), nullptr) != CE_None) return false;
  for (int b = 1; b <= static_cast<int>(info.bands.size()); ++b) {
    const GDALRasterBandH band = GDALGetRasterBand(dataset, b);
    GDALSetDescription(band, info.bands[static_cast<std::size_t>(b - 1)].c_str());
    if (info.nodata && GDALSetRasterNoDataValue(band, *info.nodata) != CE_None) return false;
  }
  const Option internal("GDAL_TIFF_INTERNAL_MASK", "YES");
  return !info.mask || GDALCreateDatasetMaskBand(dataset, GMF_PER_DATASET) == CE_None;
}

std::string create(const fs::path& file, const RasterInfo& info, void*& raster) try {
  register_drivers();
  const Quiet quiet;
  const GDALDriverH tiff = GDALGetDriverByName("GTiff"), cog = GDALGetDriverByName("COG");
  if (tiff == nullptr || cog == nullptr)
    return "this GDAL writes no cloud-optimized GeoTIFF, which came with its version 3.1";
  const std::string compression = compression_name(info.compression);
  if (std::string_view(GDALGetDriverCreationOptionList(cog)).find("<Value>" + compression + "</Value>") ==
      std::string_view::npos)
    return "this GDAL cannot compress with " + compression;
  auto made = std::make_unique<Raster>();
  made->file = file;
  made->rows_file = file.string() + ".rows.tif";
  made->info = info;
  Options options;
  options.set("TILED", "YES");
  options.set("BLOCKXSIZE", std::to_string(kBlock));
  options.set("BLOCKYSIZE", std::to_string(kBlock));
  options.set("SPARSE_OK", "TRUE");
  options.set("BIGTIFF", "IF_SAFER");
  if (info.bands.size() == 3 && info.type == SampleType::u8) options.set("PHOTOMETRIC", "RGB");
  made->rows.reset(GDALCreate(tiff, made->rows_file.c_str(), info.width, info.height,
                              static_cast<int>(info.bands.size()), data_type(info.type), options.list()));
  if (!made->rows || !describe(made->rows.get(), info)) {
    const std::string wrong = quiet.message("cannot be written");
    made->rows.reset();
    std::error_code ignored;
    fs::remove(made->rows_file, ignored);
    return wrong;
  }
  raster = made.release();
  return "";
} catch (const std::exception& error) {
  return error.what();
}

std::string write_rows(void* raster, int first_row, int rows, SampleType type, const void* samples,
                       const std::uint8_t* mask) try {
  const Quiet quiet;
  const Raster& to = *static_cast<Raster*>(raster);
  const int width = to.info.width, bands = static_cast<int>(to.info.bands.size()),
            bytes = static_cast<int>(bytes_of(type));
  void* const data = const_cast<void*>(samples);  // which GDAL only reads when it writes
  bool good = GDALDatasetRasterIOEx(to.rows.get(), GF_Write, 0, first_row, width, rows, data, width, rows,
                                    data_type(type), bands, nullptr, GSpacing{bytes} * bands,
                                    GSpacing{bytes} * bands * width, bytes, nullptr) == CE_None;
  if (good && mask != nullptr)
    good = GDALRasterIO(GDALGetMaskBand(GDALGetRasterBand(to.rows.get(), 1)), GF_Write, 0, first_row, width, rows,
                        const_cast<std::uint8_t*>(mask), width, rows, GDT_Byte, 0, 0) == CE_None;
  return good ? "" : quiet.message("cannot be written");
} catch (const std::exception& error) {
  return error.what();
}

std::string finish(void* raster, int (*go_on)(double, const char*, void*), void* data) try {
  const Quiet quiet;
  Raster& made = *static_cast<Raster*>(raster);
  const RasterInfo& info = made.info;
  // Blocks that are still in memory are written when it is closed, which tells nothing.
  GDALFlushCache(made.rows.get());
  if (quiet.failed()) return quiet.message("cannot be written");
  made.rows.reset();
  if (quiet.failed()) return quiet.message("cannot be written");
  const Dataset rows(GDALOpen(made.rows_file.c_str(), GA_ReadOnly));
  if (!rows) return quiet.message("cannot be written");
  Options options;
  options.set("COMPRESS", compression_name(info.compression));
  if (is_lossless(info.compression))
    options.set("PREDICTOR", "YES");
  else
    options.set("QUALITY", std::to_string(info.quality));
  options.set("BIGTIFF", "IF_SAFER");
  options.set("OVERVIEW_RESAMPLING", info.mean_overviews ? "AVERAGE" : "NEAREST");
  options.set("NUM_THREADS", info.threads > 0 ? std::to_string(info.threads) : "ALL_CPUS");
  const Option internal("GDAL_TIFF_INTERNAL_MASK", "YES");
  const Dataset copy(
      GDALCreateCopy(GDALGetDriverByName("COG"), made.file.c_str(), rows.get(), FALSE, options.list(), go_on, data));
  if (!copy) return quiet.message("cannot be written");
  GDALFlushCache(copy.get());
  if (quiet.failed()) return quiet.message("cannot be written");
  made.complete = true;
  return "";
} catch (const std::exception& error) {
  return error.what();
}

void close(void* raster) noexcept {
  const Quiet quiet;
  const std::unique_ptr<Raster> made(static_cast<Raster*>(raster));
  made->rows.reset();
  std::error_code ignored;
  fs::remove(made->rows_file, ignored);
  if (made->complete) return;
  // GDAL leaves its own when it is stopped.
  for (const char* end : {"", ".ovr.tmp", ".msk.ovr.tmp"}) fs::remove(made->file.string() + end, ignored);
}

}  // namespace
}  // namespace gpvc::io

const gpvc::io::RasterModule* gpvc_raster_module() {
  static constexpr gpvc::io::RasterModule kModule{gpvc::io::create, gpvc::io::write_rows, gpvc::io::finish,
                                                  gpvc::io::close};
  return &kModule;
}
