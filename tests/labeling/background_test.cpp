#include "labeling/background.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <random>

namespace gpvc::labeling {
namespace {

constexpr int kFrameWidth = 480, kFrameHeight = 360;
using Rgb = std::array<int, 3>;
using Shape = std::function<bool(int, int)>;

// Level, up is -y.
View level() {
  View view;
  view.camera = {kFrameWidth, kFrameHeight, 400, 400, kFrameWidth / 2.0, kFrameHeight / 2.0, {}};
  return view;
}
constexpr WorldPoint kUp{0, -1, 0};

Image paint(const std::function<Rgb(int, int)>& color, double noise = 2) {
  std::mt19937 random(5);
  std::normal_distribution<double> gauss(0, noise);
  Image image{kFrameWidth, kFrameHeight, 3, std::vector<std::uint8_t>(std::size_t{kFrameWidth} * kFrameHeight * 3)};
  for (int y = 0; y < kFrameHeight; ++y)
    for (int x = 0; x < kFrameWidth; ++x) {
      const Rgb rgb = color(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(rgb[c] + gauss(random), 0.0, 255.0));
    }
  return image;
}

visibility::Ivm mesh_of(const Shape& shape) {
  visibility::Ivm ivm{kFrameWidth, kFrameHeight, {}};
  for (int y = 0; y < kFrameHeight; ++y)
    for (int x = 0; x < kFrameWidth; ++x) ivm.faces.push_back(shape(x, y) ? FaceId{0} : kNoFace);
  return ivm;
}

Shape box(int x0, int y0, int x1, int y1) {
  return [=](int x, int y) { return x >= x0 && y >= y0 && x < x1 && y < y1; };
}

// A surface in focus: no two cells are alike.
Rgb brick(int x, int y) { return (x / 8 + y / 8) % 2 == 0 ? Rgb{150, 70, 60} : Rgb{90, 50, 50}; }
// It gets paler towards the horizon.
Rgb sky(int, int y) { return {120 + y / 4, 160 + y / 5, 230}; }

struct Found {
  std::size_t background = 0, excluded = 0;  // pixels of the part that is asked about
};

Found look(const Image& photo, const visibility::Ivm& ivm, const Shape& part, const WorldPoint& up = kUp) {
  BackgroundFinder finder;
  if (!finder.find(level(), photo, nullptr, ivm, up)) return {};
  Found found;
  for (int y = 0; y < kFrameHeight; ++y)
    for (int x = 0; x < kFrameWidth; ++x) {
      EXPECT_TRUE(ivm.at(x, y) != kNoFace || !finder.found().all.contains(x, y));
      if (!part(x, y)) continue;
      found.background += finder.found().background.contains(x, y) ? 1 : 0;
      found.excluded += finder.found().all.contains(x, y) ? 1 : 0;
    }
  return found;
}

// A mesh that bulges over a house by 10 pixels, before a sky with gradient and noise.
TEST(Background, IsSkyBesideAHouse) {
  const Shape house = box(140, 100, 340, 360), mesh = box(130, 90, 350, 360);
  const Image photo = paint([&](int x, int y) { return house(x, y) ? brick(x, y) : sky(x, y); });
  const std::size_t rim = 220 * 270 - 200 * 260;
  const auto beside = [&](int x, int y) { return mesh(x, y) && !house(x, y); };
  const Found found = look(photo, mesh_of(mesh), beside);
  EXPECT_GE(found.background, rim * 99 / 100);
  // Pixels of the house beside it may be mixed with it.
  const Found lost = look(photo, mesh_of(mesh), house);
  EXPECT_LE(lost.background, 20u);
  EXPECT_LE(lost.excluded, 3u * (200 + 2 * 260));
  EXPECT_GE(lost.excluded, 200u);
}

TEST(Background, GoesOnBehindAWire) {
  const Shape house = box(140, 100, 340, 360), mesh = box(110, 60, 370, 360);
  const Image photo = paint([&](int x, int y) {
    if (y >= 80 && y < 84 && x > 100) return Rgb{40, 40, 40};
    return house(x, y) ? brick(x, y) : sky(x, y);
  });
  const std::size_t below = 260 * 14;
  EXPECT_GE(look(photo, mesh_of(mesh), box(110, 85, 370, 99)).background, below * 95 / 100);
}

// The same picture from above: a mesh that ends on water, snow or fields.
TEST(Background, IsNotTheGroundThatAMeshEndsOn) {
  const Shape house = box(140, 100, 340, 360), mesh = box(0, 90, 350, 360);
  const Image photo = paint([&](int x, int y) { return house(x, y) ? brick(x, y) : sky(x, y); });
  EXPECT_EQ(look(photo, mesh_of(mesh), mesh, {0, 0, -1}).excluded, 0u);
}

TEST(Background, IsNoSurfaceWithTexture) {
  const Shape mesh = box(130, 90, 350, 360);
  const Image lawn = paint([](int x, int y) { return brick(x + 3, y + 5); });
  EXPECT_EQ(look(lawn, mesh_of(mesh), mesh).excluded, 0u);
}

// A turntable before grey, seen from above.
TEST(Background, IsABackdropAllAround) {
  const Shape thing = box(150, 100, 330, 260), mesh = box(142, 92, 338, 268);
  const Image photo = paint([&](int x, int y) { return thing(x, y) ? brick(x, y) : Rgb{128, 128, 130}; });
  const auto beside = [&](int x, int y) { return mesh(x, y) && !thing(x, y); };
  const std::size_t rim = 196 * 176 - 180 * 160;
  EXPECT_GE(look(photo, mesh_of(mesh), beside, {0, 0, -1}).background, rim * 98 / 100);
  EXPECT_LE(look(photo, mesh_of(mesh), thing, {0, 0, -1}).background, 20u);
}

// A hole that is cut out of a photo from above, noisy black, far from the frame's edge.
TEST(Background, IsWhatIsCutOut) {
  const Shape hole = box(150, 100, 270, 220), bare = box(160, 110, 260, 210);
  const Image photo = paint([&](int x, int y) { return hole(x, y) ? Rgb{7, 7, 7} : brick(x, y); }, 5);
  const visibility::Ivm ivm = mesh_of([&](int x, int y) { return !bare(x, y); });
  const auto beside = [&](int x, int y) { return hole(x, y) && !bare(x, y); };
  const std::size_t rim = 120 * 120 - 100 * 100;
  EXPECT_GE(look(photo, ivm, beside, {0, 0, -1}).background, rim * 95 / 100);
}

// A black car before black: nothing tells where it ends, so that all of it is kept.
TEST(Background, IsNoSurfaceOfItsColour) {
  const Shape car = box(100, 80, 380, 280);
  const Image photo = paint([](int, int) { return Rgb{4, 4, 4}; });
  EXPECT_EQ(look(photo, mesh_of(car), car, {0, 0, -1}).excluded, 0u);
}

// What undistortion leaves, with the noise of a JPEG file; below the border is the mesh, up to the edge of the photo.
TEST(Background, IsABlackBorder) {
  const auto is_border = [](int x, int y) {
    const double u = (x - 240) / 240.0, v = (y - 180) / 180.0;
    return std::abs(u) > 0.97 - 0.05 * v * v || std::abs(v) > 0.97 - 0.05 * u * u;
  };
  const Image photo = paint([&](int x, int y) { return is_border(x, y) ? Rgb{1, 1, 1} : brick(x, y); }, 3);
  const visibility::Ivm ivm = mesh_of([](int, int) { return true; });
  std::size_t border = 0;
  for (int y = 0; y < kFrameHeight; ++y)
    for (int x = 0; x < kFrameWidth; ++x) border += is_border(x, y) ? 1 : 0;
  const Found found = look(photo, ivm, is_border, {0, 0, -1});
  EXPECT_GE(found.excluded, border * 97 / 100);
  EXPECT_EQ(found.background, 0u);  // it tells nothing of the surface
  EXPECT_LE(look(photo, ivm, [&](int x, int y) { return !is_border(x, y); }, {0, 0, -1}).excluded, border / 2);
}

// A tunnel's mouth and a black car at the photo's edge are no border.
TEST(Background, IsNoBlackThing) {
  const Shape tunnel = box(200, 150, 280, 230), car = box(0, 100, 60, 140);
  const Image photo = paint([&](int x, int y) { return tunnel(x, y) || car(x, y) ? Rgb{2, 2, 2} : brick(x, y); });
  const visibility::Ivm ivm = mesh_of([](int, int) { return true; });
  EXPECT_EQ(look(photo, ivm, [](int, int) { return true; }).excluded, 0u);
}

}  // namespace
}  // namespace gpvc::labeling
