// A GeoTIFF as GDAL reads it.
#pragma once

#include <cpl_conv.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace gpvc::test {

struct RasterFile {
  int width = 0, height = 0, bands = 0, overviews = 0;
  std::array<double, 6> place{};
  std::string system, layout, compression, software, type;  ///< system: "EPSG:32632", or its PROJ string; empty: none
  std::vector<std::string> names;
  double nodata = 0;
  bool has_nodata = false, has_mask = false;
  std::vector<double> values;       ///< row-major, all bands of a pixel together
  std::vector<unsigned char> mask;  ///< of the first band

  double at(int x, int y, int band = 0) const {
    return values[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
                      static_cast<std::size_t>(bands) +
                  static_cast<std::size_t>(band)];
  }
  unsigned char mask_at(int x, int y) const {
    return mask[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
  /// The pixel over a place.
  std::array<int, 2> pixel_of(double x, double y) const {
    return {static_cast<int>((x - place[0]) / place[1]), static_cast<int>((y - place[3]) / place[5])};
  }
};

inline std::string text_of(const char* text) { return text == nullptr ? "" : text; }

inline std::string system_of(GDALDatasetH dataset) {
  const OGRSpatialReferenceH system = GDALGetSpatialRef(dataset);
  if (system == nullptr) return "";
  if (const char* code = OSRGetAuthorityCode(system, nullptr); code != nullptr) return std::string("EPSG:") + code;
  char* proj = nullptr;
  EXPECT_EQ(OSRExportToProj4(system, &proj), OGRERR_NONE);
  const std::string text = text_of(proj);
  CPLFree(proj);
  return text;
}

inline RasterFile read_raster(const std::filesystem::path& file) {
  GDALRegister_GTiff();
  RasterFile raster;
  const GDALDatasetH dataset = GDALOpen(file.c_str(), GA_ReadOnly);
  EXPECT_NE(dataset, nullptr) << file;
  if (dataset == nullptr) return raster;
  raster.width = GDALGetRasterXSize(dataset);
  raster.height = GDALGetRasterYSize(dataset);
  raster.bands = GDALGetRasterCount(dataset);
  EXPECT_EQ(GDALGetGeoTransform(dataset, raster.place.data()), CE_None);
  raster.system = system_of(dataset);
  raster.layout = text_of(GDALGetMetadataItem(dataset, "LAYOUT", "IMAGE_STRUCTURE"));
  raster.compression = text_of(GDALGetMetadataItem(dataset, "COMPRESSION", "IMAGE_STRUCTURE"));
  raster.software = text_of(GDALGetMetadataItem(dataset, "TIFFTAG_SOFTWARE", nullptr));
  const GDALRasterBandH first = GDALGetRasterBand(dataset, 1);
  raster.overviews = GDALGetOverviewCount(first);
  raster.type = GDALGetDataTypeName(GDALGetRasterDataType(first));
  int has_nodata = 0;
  raster.nodata = GDALGetRasterNoDataValue(first, &has_nodata);
  raster.has_nodata = has_nodata != 0;
  raster.has_mask = GDALGetMaskFlags(first) == GMF_PER_DATASET;
  for (int b = 1; b <= raster.bands; ++b) raster.names.push_back(GDALGetDescription(GDALGetRasterBand(dataset, b)));
  const auto pixels = static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height);
  raster.values.resize(pixels * static_cast<std::size_t>(raster.bands));
  const int bytes = sizeof(double);
  EXPECT_EQ(GDALDatasetRasterIO(dataset, GF_Read, 0, 0, raster.width, raster.height, raster.values.data(), raster.width,
                                raster.height, GDT_Float64, raster.bands, nullptr, bytes * raster.bands,
                                bytes * raster.bands * raster.width, bytes),
            CE_None);
  raster.mask.resize(pixels);
  EXPECT_EQ(GDALRasterIO(GDALGetMaskBand(first), GF_Read, 0, 0, raster.width, raster.height, raster.mask.data(),
                         raster.width, raster.height, GDT_Byte, 0, 0),
            CE_None);
  GDALClose(dataset);
  return raster;
}

}  // namespace gpvc::test
