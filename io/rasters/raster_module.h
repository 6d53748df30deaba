// What writes rasters with GDAL.
//
// GDAL loads some hundred libraries. So what calls it is a module, as that of image formats is (io/images/other_formats.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "io/raster.h"

namespace gpvc::io {

/// All but close() return what is wrong, in a line without the file's name, or nothing. Rasters are independent of each other.
struct RasterModule {
  std::string (*create)(const std::filesystem::path& file, const RasterInfo& info, void*& raster);
  std::string (*write_rows)(void* raster, int first_row, int rows, SampleType type, const void* samples,
                            const std::uint8_t* mask);
  /// Stops, without a file, where go_on(share, data) returns 0.
  std::string (*finish)(void* raster, int (*go_on)(double share, const char*, void* data), void* data);
  /// Removes what finish() has not completed.
  void (*close)(void* raster) noexcept;
};

/// Throws OutputError, which names `file` as what needs it, if the module can't be opened.
const RasterModule& raster_module(const std::filesystem::path& file);

}  // namespace gpvc::io

/// What the module exports.
extern "C" [[gnu::visibility("default")]] const gpvc::io::RasterModule* gpvc_raster_module();
