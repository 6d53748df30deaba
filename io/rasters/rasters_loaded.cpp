// For programs, and for the shared library, which find the module by their RUNPATH.
#include "io/files/module.h"
#include "io/rasters/raster_module.h"

namespace gpvc::io {

const RasterModule& raster_module(const std::filesystem::path& file) {
  static const auto module = open_module<RasterModule>(GPVC_RASTERS_MODULE, "gpvc_raster_module");
  if (module.functions == nullptr)
    throw OutputError(file, "the module that writes GeoTIFF cannot be opened: " + module.why);
  return *module.functions;
}

}  // namespace gpvc::io
