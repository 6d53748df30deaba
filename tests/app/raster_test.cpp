// io/raster.h, read back by GDAL.
#include "io/raster.h"

#include <gtest/gtest.h>

#include <numeric>

#include "io/images.h"
#include "io/reference_system.h"
#include "tests/support/errors.h"
#include "tests/support/raster_file.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

using namespace test;

io::RasterInfo colors(int width, int height) {
  io::RasterInfo info;
  info.width = width;
  info.height = height;
  info.west = 448100;
  info.north = 5411400;
  info.pixel_size = 0.05;
  info.bands = {"red", "green", "blue"};
  info.mask = true;
  return info;
}

TEST(Raster, ComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  io::RasterInfo info = colors(700, 600);
  info.wkt = io::system_wkt("EPSG:25832");
  std::vector<std::uint8_t> rgb(3 * 700 * 600), mask(700 * 600);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<std::uint8_t>(i * i % 251);
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = i % 700 < 350 ? 255 : 0;
  {
    io::RasterWriter writer(folder.path() / "a.tif", info);
    for (int row = 0; row < 600; row += 250) {
      const int rows = std::min(250, 600 - row);
      writer.write_rows(row, rows, rgb.data() + 3 * 700 * row, mask.data() + 700 * row);
    }
    writer.finish();
  }
  EXPECT_EQ(folder.count(), 1u) << "nothing else is left";
  const RasterFile read = read_raster(folder.path() / "a.tif");
  EXPECT_EQ(read.system, "EPSG:25832");
  EXPECT_EQ(read.place, (std::array<double, 6>{448100, 0.05, 0, 5411400, 0, -0.05}));
  EXPECT_EQ(read.layout, "COG");
  EXPECT_GE(read.overviews, 1);
  EXPECT_EQ(read.names, info.bands);
  EXPECT_TRUE(read.has_mask);
  EXPECT_EQ(read.mask, mask);
  ASSERT_EQ(read.values.size(), rgb.size());
  EXPECT_TRUE(std::equal(rgb.begin(), rgb.end(), read.values.begin()));
}

// Pages' samples are no georeferenced raster, but GDAL knows their bands and which texels have a value.
TEST(Raster, PagesOfSamplesAreKnownToGdal) {
  const TemporaryFolder folder;
  Samples samples{300, 200, 5, SampleType::u16, {}};
  samples.bytes.resize(samples.pixel_bytes() * 300 * 200);
  std::vector<std::uint8_t> mask(300 * 200);
  BandSet set;
  for (std::size_t b = 0; b < 5; ++b) set.bands.push_back({"Band " + std::to_string(b + 1), {}, "reflectance"});
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 300; ++x) {
      for (std::size_t b = 0; b < 5; ++b)
        store_sample(samples.at(x, y) + 2 * b, SampleType::u16, static_cast<float>(x * 200 + y + static_cast<int>(b)));
      mask[pixel_index(x, y, 300)] = (x / 3 + y / 5) % 2 == 0 ? 255 : 0;
    }
  io::write_samples(folder.path() / "model_0.tif", samples, set, mask);
  GDALAllRegister();
  const GDALDatasetH dataset = GDALOpen((folder.path() / "model_0.tif").c_str(), GA_ReadOnly);
  ASSERT_NE(dataset, nullptr);
  ASSERT_EQ(GDALGetRasterCount(dataset), 5);
  const GDALRasterBandH last = GDALGetRasterBand(dataset, 5);
  EXPECT_EQ(GDALGetRasterDataType(last), GDT_UInt16);
  EXPECT_STREQ(GDALGetDescription(last), "Band 5");
  EXPECT_STREQ(GDALGetRasterUnitType(last), "reflectance");
  EXPECT_EQ(GDALGetMaskFlags(last), GMF_PER_DATASET);
  std::vector<std::uint16_t> values(300 * 200);
  std::vector<std::uint8_t> shown(300 * 200);
  ASSERT_EQ(GDALRasterIO(last, GF_Read, 0, 0, 300, 200, values.data(), 300, 200, GDT_UInt16, 0, 0), CE_None);
  ASSERT_EQ(GDALRasterIO(GDALGetMaskBand(last), GF_Read, 0, 0, 300, 200, shown.data(), 300, 200, GDT_Byte, 0, 0),
            CE_None);
  GDALClose(dataset);
  EXPECT_EQ(shown, mask);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 300; ++x) ASSERT_EQ(values[pixel_index(x, y, 300)], x * 200 + y + 4);
}

TEST(Raster, NumbersAreClampedToTheTypeOfTheFile) {
  const TemporaryFolder folder;
  io::RasterInfo info = colors(2, 1);
  info.bands = {"photo"};
  info.mask = false;
  info.type = SampleType::u16;
  info.nodata = 65535;
  io::RasterWriter writer(folder.path() / "a.tif", info);
  const std::array<std::uint32_t, 2> numbers{7, 0xFFFFFFFFU};
  writer.write_rows(0, 1, numbers.data());
  writer.finish();
  const RasterFile read = read_raster(folder.path() / "a.tif");
  EXPECT_EQ(read.type, "UInt16");
  EXPECT_EQ(read.nodata, 65535);
  EXPECT_EQ(read.values, (std::vector<double>{7, 65535}));
  EXPECT_EQ(read.mask, (std::vector<unsigned char>{255, 0}));
}

TEST(Raster, LeavesNothingUnlessItIsFinished) {
  const TemporaryFolder folder;
  const std::vector<std::uint8_t> rgb(3 * 600 * 600, 9), mask(600 * 600, 255);
  {
    io::RasterWriter writer(folder.path() / "a.tif", colors(600, 600));
    writer.write_rows(0, 600, rgb.data(), mask.data());
  }
  EXPECT_EQ(folder.count(), 0u);
  {
    io::RasterWriter writer(folder.path() / "a.tif", colors(600, 600));
    writer.write_rows(0, 600, rgb.data(), mask.data());
    EXPECT_THROW(writer.finish([](std::size_t, std::size_t) { throw Cancelled(); }), Cancelled);
  }
  EXPECT_EQ(folder.count(), 0u);
}

TEST(Raster, SaysInALineWhatItCannotWrite) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "none" / "a.tif";
  const std::optional<Error> error = caught([&] { io::RasterWriter(file, colors(10, 10)); });
  ASSERT_TRUE(error);
  EXPECT_TRUE(contains(error->what(), file.string() + ": cannot be written: "));
  EXPECT_EQ(std::string(error->what()).find('\n'), std::string::npos);
  io::RasterInfo info = colors(10, 10);
  info.wkt = "PROJCRS[";
  EXPECT_TRUE(caught([&] { io::RasterWriter(folder.path() / "a.tif", info); }));
  EXPECT_EQ(folder.count(), 0u);
}

}  // namespace
}  // namespace gpvc
