// For static libraries, which GDAL is linked to.
#include "io/rasters/raster_module.h"

namespace gpvc::io {

const RasterModule& raster_module(const std::filesystem::path&) { return *gpvc_raster_module(); }

}  // namespace gpvc::io
