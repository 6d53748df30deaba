// Orthophotos of small models whose look from above is known.
#include "app/ortho/ortho.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "io/reference_system.h"
#include "tests/support/errors.h"
#include "tests/support/raster_file.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;
using ortho::FaceKind;
using Color = std::array<std::uint8_t, 3>;
constexpr Color kRed{255, 0, 0}, kGreen{0, 255, 0}, kBlue{0, 0, 255};

/// A model that is put together from quads.
class Model {
 public:
  explicit Model(const fs::path& folder) : pages(folder) {}

  /// A page in one colour.
  std::uint32_t page(const Color& color) {
    Image image{4, 4, 3, {}};
    for (int i = 0; i < 16; ++i) image.pixels.insert(image.pixels.end(), color.begin(), color.end());
    return page(std::move(image));
  }
  std::uint32_t page(Image image) {
    pages.take_page(pages.size(), std::move(image));
    return static_cast<std::uint32_t>(pages.size() - 1);
  }
  /// Two faces that show the whole page, the first corner at its lower left.
  void quad(const std::array<WorldPoint, 4>& corners, std::uint32_t page, FaceKind kind = FaceKind::textured,
            std::uint32_t photo = 0) {
    const auto first = static_cast<std::uint32_t>(surface.mesh.positions.size());
    const std::array<io::TexCoord, 4> texture{{{0, 1}, {1, 1}, {1, 0}, {0, 0}}};
    for (std::size_t i = 0; i < 4; ++i) {
      surface.mesh.positions.push_back(corners[i]);
      surface.model.texcoords.push_back(texture[i]);
    }
    for (const Triangle& face : {Triangle{first, first + 1, first + 2}, Triangle{first, first + 2, first + 3}}) {
      surface.mesh.faces.push_back(face);
      surface.model.face_texcoords.push_back(face);
      surface.model.face_page.push_back(page);
      surface.kind.push_back(kind);
      surface.photo.push_back(kind == FaceKind::textured ? photo : ortho::kNoPhoto);
    }
  }
  void level(double x0, double y0, double x1, double y1, double z, std::uint32_t page,
             FaceKind kind = FaceKind::textured, std::uint32_t photo = 0) {
    quad({WorldPoint{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}}, page, kind, photo);
  }
  void set_photos(std::uint32_t count) {
    for (std::uint32_t n = 0; n < count; ++n) surface.photos.push_back("photo " + std::to_string(n) + ".jpg");
  }

  ortho::PageStore pages;
  ortho::Surface surface;
};

class Ortho : public testing::Test {
 protected:
  Ortho() : model_(folder_.path()) { model_.surface.source = "mesh.ply"; }

  /// Draws into a folder of this name.
  fs::path draw(const ortho::OrthoSettings& settings, const std::string& name = "out") {
    model_.pages.complete();
    if (model_.surface.photos.empty()) model_.set_photos(2);
    ortho::Surface surface = model_.surface;
    const ortho::Frame frame = ortho::place_surface(surface, settings);
    pipeline::Observer silent;
    pipeline::OutputFolder folder(folder_.path() / name);
    ortho::write_ortho(surface, model_.pages, frame, settings, folder, silent);
    folder.publish();
    return folder_.path() / name;
  }
  static ortho::OrthoSettings with_gsd(double gsd) {
    ortho::OrthoSettings settings;
    settings.gsd = gsd;
    return settings;
  }

  TemporaryFolder folder_;
  Model model_;
};

// The share of a channel in a row, in pixels, and where its middle lies.
struct Extent {
  double length = 0, middle = 0;
};
Extent extent_in_row(const RasterFile& raster, int row, int band) {
  Extent extent;
  for (int x = 0; x < raster.width; ++x) {
    const double share = raster.at(x, row, band) / 255;
    extent.length += share;
    extent.middle += share * (x + 0.5);
  }
  extent.middle /= extent.length;
  return extent;
}

/// A page of 4 x 4 texels in one colour whose samples are the numbers of their band, thousands of 16 bits.
void take_banded_page(ortho::PageStore& pages, float first) {
  const std::size_t number = pages.size();
  BandSet set;
  for (const char* name : {"Blue", "Green", "Red", "NIR"}) set.bands.push_back({name, {}, {}});
  Samples samples{4, 4, 4, SampleType::u16, {}};
  samples.bytes.resize(samples.pixel_bytes() * 16);
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t b = 0; b < 4; ++b)
      store_sample(samples.bytes.data() + 8 * i + 2 * b, SampleType::u16, first + 1000 * static_cast<float>(b));
  pages.take_samples(number, {std::move(samples), {}}, set);
  Image image{4, 4, 3, std::vector<std::uint8_t>(48, 100)};
  pages.take_page(number, std::move(image));
}

TEST_F(Ortho, ShowsAllBandsOfPagesThatHaveThem) {
  take_banded_page(model_.pages, 100);
  take_banded_page(model_.pages, 20000);
  model_.level(0, 0, 10, 10, 0, 0);
  model_.level(4, 4, 8, 8, 3, 1, FaceKind::textured, 1);
  const fs::path out = draw(with_gsd(0.5));
  const RasterFile bands = read_raster(out / "ortho_bands.tif"), colors = read_raster(out / "ortho.tif");
  ASSERT_EQ(bands.bands, 4);
  EXPECT_EQ(bands.type, "UInt16");
  EXPECT_EQ(bands.names, (std::vector<std::string>{"Blue", "Green", "Red", "NIR"}));
  EXPECT_EQ(bands.place, colors.place);
  EXPECT_EQ(bands.mask, colors.mask);
  const auto [roof_x, roof_y] = bands.pixel_of(6, 6);
  const auto [ground_x, ground_y] = bands.pixel_of(1.25, 1.25);
  for (int b = 0; b < 4; ++b) {
    EXPECT_EQ(bands.at(roof_x, roof_y, b), 20000 + 1000 * b);
    EXPECT_EQ(bands.at(ground_x, ground_y, b), 100 + 1000 * b);
  }
}

// A model of which one page has no samples has no bands that could be shown.
TEST_F(Ortho, HasNoBandsWhereAPageHasNone) {
  take_banded_page(model_.pages, 100);
  const std::uint32_t plain = model_.page(kRed);
  model_.level(0, 0, 10, 10, 0, 0);
  model_.level(4, 4, 8, 8, 3, plain, FaceKind::textured, 1);
  const fs::path out = draw(with_gsd(0.5));
  EXPECT_TRUE(fs::exists(out / "ortho.tif"));
  EXPECT_FALSE(fs::exists(out / "ortho_bands.tif"));
}

TEST_F(Ortho, RoofsLieWhereTheyStandAndWallsDoNotShow) {
  const std::uint32_t ground = model_.page(kGreen), roof = model_.page(kRed), wall = model_.page(kBlue);
  model_.level(0, 0, 20, 20, 0, ground, FaceKind::textured, 0);
  const double x0 = 5.03, y0 = 7.02, x1 = 11.07, y1 = 12.04, in = 0.4;  // walls stand in from the eaves
  model_.level(x0, y0, x1, y1, 4, roof, FaceKind::textured, 1);
  model_.quad({WorldPoint{x0 + in, y0 + in, 0}, {x1 - in, y0 + in, 0}, {x1, y0, 4}, {x0, y0, 4}}, wall);
  model_.quad({WorldPoint{x0 + in, y1 - in, 0}, {x1 - in, y1 - in, 0}, {x1, y1, 4}, {x0, y1, 4}}, wall);
  model_.quad({WorldPoint{x0, y0, 0}, {x0, y1, 0}, {x0, y1, 4}, {x0, y0, 4}}, wall);  // and this one upright
  const fs::path out = draw(with_gsd(0.1));
  const RasterFile colors = read_raster(out / "ortho.tif"), heights = read_raster(out / "ortho_height.tif"),
                   photos = read_raster(out / "ortho_photo.tif");
  ASSERT_EQ(colors.width, 200);
  ASSERT_EQ(colors.height, 200);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) ASSERT_EQ(colors.at(x, y, 2), 0) << "a wall shows in pixel " << x << ", " << y;
  const Extent across = extent_in_row(colors, 100, 0);
  EXPECT_NEAR(across.length, (x1 - x0) / 0.1, 0.2) << "each edge within a tenth of a pixel";
  EXPECT_NEAR(across.middle, (x0 + x1) / 2 / 0.1, 0.1);
  for (const auto& [x, y, height, photo] :
       {std::array{x0 + 0.1, y0 + 0.1, 4.0, 1.0}, std::array{x0 - 0.1, y0 + 0.1, 0.0, 0.0},
        std::array{x1 - 0.1, y1 - 0.1, 4.0, 1.0}, std::array{x1 + 0.1, y1 + 0.1, 0.0, 0.0}}) {
    const auto [column, row] = heights.pixel_of(x, y);
    EXPECT_EQ(heights.at(column, row), height) << x << ", " << y;
    EXPECT_EQ(photos.at(column, row), photo) << x << ", " << y;
  }
  EXPECT_EQ(read_file(out / "ortho_photos.csv"), "number,photo\n0,photo 0.jpg\n1,photo 1.jpg\n");
}

// A sheet of randomly moved vertices, over another colour that would show through any gap.
TEST_F(Ortho, FacesAndTilesLeaveNoGap) {
  const std::uint32_t above = model_.page(kRed), below = model_.page(kGreen);
  model_.level(0, 0, 30, 30, -5, below);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> move(-0.45, 0.45);
  constexpr std::uint32_t kSide = 61;
  const auto first = static_cast<std::uint32_t>(model_.surface.mesh.positions.size());
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const bool rim = x == 0 || y == 0 || x == kSide - 1 || y == kSide - 1;
      model_.surface.mesh.positions.push_back(
          {0.5 * (x + (rim ? 0 : move(random))), 0.5 * (y + (rim ? 0 : move(random))), rim ? 0 : move(random)});
      model_.surface.model.texcoords.push_back({0.5f, 0.5f});
    }
  for (std::uint32_t y = 0; y + 1 < kSide; ++y)
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t at = first + y * kSide + x;
      for (const Triangle& face : {Triangle{at, at + 1, at + kSide}, Triangle{at + 1, at + kSide + 1, at + kSide}}) {
        model_.surface.mesh.faces.push_back(face);
        model_.surface.model.face_texcoords.push_back(face);
        model_.surface.model.face_page.push_back(above);
        model_.surface.kind.push_back(FaceKind::textured);
        model_.surface.photo.push_back(0);
      }
    }
  const RasterFile colors = read_raster(draw(with_gsd(0.05)) / "ortho.tif");
  ASSERT_EQ(colors.width, 600);
  for (int y = 0; y < colors.height; ++y)
    for (int x = 0; x < colors.width; ++x) {
      ASSERT_EQ(colors.at(x, y, 0), 255) << x << ", " << y;
      ASSERT_EQ(colors.at(x, y, 1), 0) << x << ", " << y;
      ASSERT_EQ(colors.mask_at(x, y), 255) << x << ", " << y;
    }
}

TEST_F(Ortho, TilesAndThreadsDoNotMatter) {
  Image noise{64, 64, 3, {}};
  std::mt19937 random(3);
  for (int i = 0; i < 64 * 64 * 3; ++i) noise.pixels.push_back(static_cast<std::uint8_t>(random() % 256));
  const std::uint32_t page = model_.page(std::move(noise));
  std::uniform_real_distribution<double> place(0, 30), height(0, 10);
  for (std::uint32_t i = 0; i < 60; ++i) {
    const auto point = [&] { return WorldPoint{place(random), place(random), height(random)}; };
    model_.quad({point(), point(), point(), point()}, page, i % 7 == 0 ? FaceKind::bare : FaceKind::textured, i % 2);
  }
  ortho::OrthoSettings settings = with_gsd(0.04);
  const fs::path large = draw(settings, "large");
  settings.tile_samples = 64;
  const fs::path small = draw(settings, "small");
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const fs::path alone = draw(settings, "alone");
  for (const char* name : {"ortho.tif", "ortho_height.tif", "ortho_photo.tif"}) {
    EXPECT_TRUE(read_file(large / name) == read_file(small / name)) << name;
    EXPECT_TRUE(read_file(large / name) == read_file(alone / name)) << name;
  }
}

TEST_F(Ortho, APixelIsTheMeanOfItsTexels) {
  Image board{256, 256, 3, {}};
  for (int i = 0; i < 256 * 256; ++i) {
    const auto value = static_cast<std::uint8_t>((i % 256 + i / 256) % 2 == 0 ? 40 : 200);
    board.pixels.insert(board.pixels.end(), 3, value);
  }
  model_.level(0, 0, 16, 16, 1, model_.page(std::move(board)));
  // 8 texels across a pixel, then 12.
  for (const double gsd : {0.5, 0.75}) {
    const RasterFile colors = read_raster(draw(with_gsd(gsd), std::to_string(gsd)) / "ortho.tif");
    for (int y = 0; y < 16 / gsd - 1; ++y)
      for (int x = 0; x < 16 / gsd - 1; ++x) ASSERT_NEAR(colors.at(x, colors.height - 1 - y), 120, 3) << x << ", " << y;
  }
}

TEST_F(Ortho, TexturesAndSlopesLieWhereTheirFacesHaveThem) {
  Image ramp{250, 2, 3, {}};
  for (int i = 0; i < 2 * 250; ++i) ramp.pixels.insert(ramp.pixels.end(), 3, static_cast<std::uint8_t>(i % 250));
  model_.quad({WorldPoint{0, 0, 0}, {250, 0, 25}, {250, 10, 25}, {0, 10, 0}}, model_.page(std::move(ramp)));
  const fs::path out = draw(with_gsd(1));
  const RasterFile colors = read_raster(out / "ortho.tif"), heights = read_raster(out / "ortho_height.tif");
  ASSERT_EQ(colors.width, 250);
  for (int x = 0; x < 250; ++x) {
    EXPECT_EQ(colors.at(x, 4), x);
    EXPECT_NEAR(heights.at(x, 4), 0.1 * (x + 0.5), 1e-5);
  }
}

TEST_F(Ortho, WithoutAPixelSizeItIsThatOfATexel) {
  Image page{200, 200, 3, std::vector<std::uint8_t>(3 * 200 * 200, 99)};
  model_.level(0, 0, 7, 7, 1, model_.page(std::move(page)));
  const RasterFile colors = read_raster(draw({}) / "ortho.tif");
  EXPECT_EQ(colors.place[1], 0.035);
  EXPECT_EQ(colors.width, 200);
}

TEST_F(Ortho, WhatNoPhotoShowsHidesAndHasAHeight) {
  const std::uint32_t ground = model_.page(kGreen), page = model_.page(kRed);
  model_.level(0, 0, 10, 10, 0, ground);
  model_.level(2, 2, 4, 4, 3, page, FaceKind::bare);
  model_.level(6, 6, 8, 8, 5, page, FaceKind::absent);
  const fs::path out = draw(with_gsd(0.5));
  const RasterFile colors = read_raster(out / "ortho.tif"), heights = read_raster(out / "ortho_height.tif"),
                   photos = read_raster(out / "ortho_photo.tif");
  const auto [x, y] = colors.pixel_of(3.1, 3.1);
  EXPECT_EQ(colors.mask_at(x, y), 0);
  EXPECT_EQ(heights.at(x, y), 3);
  EXPECT_EQ(photos.at(x, y), 65535);
  const auto [u, v] = colors.pixel_of(7.1, 7.1);
  EXPECT_EQ(colors.mask_at(u, v), 255);
  EXPECT_EQ(colors.at(u, v, 1), 255);
  EXPECT_EQ(heights.at(u, v), 0);
  EXPECT_EQ(photos.at(u, v), 0);
  EXPECT_EQ(heights.nodata, ortho::kNoHeight);
  EXPECT_EQ(heights.type, "Float32");
}

TEST_F(Ortho, OutsideOfTheModelIsNothing) {
  const std::uint32_t page = model_.page(kGreen);
  model_.quad({WorldPoint{0, 0, 2}, {10, 0, 2}, {0, 10, 2}, {0, 10, 2}}, page);  // a triangle
  const fs::path out = draw(with_gsd(0.5));
  const RasterFile colors = read_raster(out / "ortho.tif"), heights = read_raster(out / "ortho_height.tif");
  const auto [x, y] = colors.pixel_of(8, 8);
  EXPECT_EQ(colors.mask_at(x, y), 0);
  EXPECT_EQ(heights.at(x, y), ortho::kNoHeight);
}

TEST_F(Ortho, PixelsAreMultiplesOfTheirSizeInTheReferenceSystem) {
  const std::uint32_t ground = model_.page(kGreen), spot = model_.page(kRed);
  model_.surface.coordinates.srs = "EPSG:25832";
  model_.surface.coordinates.srs_offset = {448000, 5411000, 300};
  model_.surface.coordinates.offset = {100.013, 200.027, 0};
  model_.level(0, 0, 60, 40, 0, ground);
  model_.level(30, 20, 31, 21, 1, spot);
  const fs::path out = draw(with_gsd(0.05));
  const RasterFile colors = read_raster(out / "ortho.tif"), heights = read_raster(out / "ortho_height.tif");
  EXPECT_EQ(colors.system, "EPSG:25832");
  EXPECT_DOUBLE_EQ(colors.place[0], 448100.0);
  EXPECT_DOUBLE_EQ(colors.place[3], 5411240.05);
  const auto [x, y] = colors.pixel_of(448130.513, 5411220.527);
  EXPECT_EQ(colors.at(x, y, 0), 255);
  EXPECT_FLOAT_EQ(static_cast<float>(heights.at(x, y)), 301);
  const auto [u, v] = colors.pixel_of(448131.063, 5411220.527);
  EXPECT_EQ(colors.at(u, v, 0), 0);
}

// A spot's geocentric place, by the raster's own reference system.
WorldPoint geocentric(const std::string& system, double x, double y, double z) {
  std::vector<WorldPoint> point{{x, y, z}};
  io::transform_points(system, io::kGeocentric, point);
  return point.front();
}

TEST_F(Ortho, EastNorthUpLiesOnTheEarthWhereItIs) {
  const std::uint32_t ground = model_.page(kGreen), spot = model_.page(kRed);
  model_.surface.coordinates.srs = "ENU:46.5,8.25";
  model_.level(-1200, -900, 1200, 900, 1500, ground);
  model_.level(1000, 700, 1010, 710, 1501, spot);
  const fs::path here = draw(with_gsd(1), "here");
  ortho::OrthoSettings utm = with_gsd(1);
  utm.crs = "EPSG:32632";
  const fs::path there = draw(utm, "there");
  std::array<WorldPoint, 2> middle;
  for (std::size_t i = 0; i < 2; ++i) {
    const RasterFile colors = read_raster((i == 0 ? here : there) / "ortho.tif");
    const RasterFile heights = read_raster((i == 0 ? here : there) / "ortho_height.tif");
    double count = 0, x = 0, y = 0, z = 0;
    for (int row = 0; row < colors.height; ++row)
      for (int column = 0; column < colors.width; ++column) {
        const double share = colors.at(column, row, 0) / 255;
        count += share;
        x += share * (column + 0.5);
        y += share * (row + 0.5);
        if (share == 1) z = heights.at(column, row);
      }
    EXPECT_NEAR(count, 100, 2) << "a metre is a metre";
    middle[i] = geocentric(colors.system, colors.place[0] + x / count, colors.place[3] - y / count, z);
  }
  EXPECT_EQ(read_raster(there / "ortho.tif").system, "EPSG:32632");
  // 0.12 m is what the earth's curve makes of the height at 1.2 km.
  const double apart = std::hypot(middle[0].x - middle[1].x, middle[0].y - middle[1].y, middle[0].z - middle[1].z);
  EXPECT_LT(apart, 0.2);
}

TEST_F(Ortho, GeocentricCoordinatesAreDrawnInTheirUtmZone) {
  const std::uint32_t ground = model_.page(kGreen);
  model_.level(448100, 5411200, 448200, 5411300, 350, ground);
  io::transform_points("EPSG:32632", io::kGeocentric, model_.surface.mesh.positions);
  model_.surface.coordinates.srs = io::kGeocentric;
  const fs::path out = draw(with_gsd(1));
  const RasterFile colors = read_raster(out / "ortho.tif");
  EXPECT_EQ(colors.system, "EPSG:32632");
  EXPECT_NEAR(colors.place[0], 448100, 1.001);
  EXPECT_NEAR(colors.place[3], 5411300, 1.001);
  EXPECT_NEAR(read_raster(out / "ortho_height.tif").at(50, 50), 350, 0.01);
}

TEST_F(Ortho, AnotherAxisMayPointUp) {
  const std::uint32_t ground = model_.page(kGreen), spot = model_.page(kRed);
  // y is down: x to the right, z up the picture.
  model_.quad({WorldPoint{0, 2, 0}, {10, 2, 0}, {10, 2, 10}, {0, 2, 10}}, ground);
  model_.quad({WorldPoint{8, 1, 8}, {9, 1, 8}, {9, 1, 9}, {8, 1, 9}}, spot);
  model_.surface.up = WorldPoint{0.02, -1, 0.01};
  const fs::path out = draw(with_gsd(0.1));
  const RasterFile colors = read_raster(out / "ortho.tif"), heights = read_raster(out / "ortho_height.tif");
  EXPECT_EQ(colors.system, "");
  EXPECT_EQ(colors.width, 100);
  EXPECT_EQ(colors.height, 100);
  int spots = 0;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      if (colors.at(x, y, 0) != 255) continue;
      ++spots;
      EXPECT_EQ(heights.at(x, y), -1);
    }
  EXPECT_EQ(spots, 100);
  // Far from all axes it is the direction itself.
  model_.surface.up = WorldPoint{0.3, -1, 0.2};
  EXPECT_GT(read_raster(draw(with_gsd(0.1), "turned") / "ortho.tif").width, 1);
}

TEST_F(Ortho, BoundsCutOut) {
  const std::uint32_t ground = model_.page(kGreen);
  model_.level(0, 0, 100, 100, 0, ground);
  ortho::OrthoSettings settings = with_gsd(0.3);
  settings.bounds = ortho::Bounds{10, 20, 16.1, 23};
  const RasterFile colors = read_raster(draw(settings) / "ortho.tif");
  EXPECT_NEAR(colors.place[0], 9.9, 1e-9);
  EXPECT_NEAR(colors.place[3], 23.1, 1e-9);
  EXPECT_EQ(colors.width, 21);
  EXPECT_EQ(colors.height, 11);
  EXPECT_EQ(colors.mask_at(20, 10), 255);
}

TEST_F(Ortho, RefusesInASentenceWhatCannotBeDrawn) {
  const std::uint32_t ground = model_.page(kGreen);
  model_.level(0, 0, 100, 100, 0, ground);
  const auto refused = [&](const ortho::OrthoSettings& settings) {
    const std::optional<Error> error = caught([&] { draw(settings); });
    EXPECT_TRUE(error);
    EXPECT_FALSE(fs::exists(folder_.path() / "out"));
    return std::string(error ? error->what() : "");
  };
  ortho::OrthoSettings beside = with_gsd(1);
  beside.bounds = ortho::Bounds{200, 200, 300, 300};
  EXPECT_EQ(refused(beside), "mesh.ply: lies within 0, 0 to 100, 100, beside the bounds 200, 200 to 300, 300");
  EXPECT_EQ(
      refused(with_gsd(1e-7)),
      "mesh.ply: has 1000000000 x 1000000000 pixels of 1e-07 units within 0, 0 to 100, 100, expected 10000000 along "
      "an edge at most");
  ortho::OrthoSettings unknown = with_gsd(1);
  unknown.crs = "EPSG:25832";
  EXPECT_EQ(refused(unknown), "mesh.ply: is in no known reference system, so that it cannot be taken to EPSG:25832");
  model_.surface.coordinates.srs = "EPSG:25832";
  model_.surface.coordinates.srs_offset = {448000, 5411000, 300};
  unknown.crs = "EPSG:1";
  EXPECT_TRUE(contains(refused(unknown), "'EPSG:1' is no coordinate reference system that PROJ knows"));
}

}  // namespace
}  // namespace gpvc
