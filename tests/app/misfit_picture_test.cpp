// Where cuts misfit, in a picture.
#include "app/pipeline/misfit_picture.h"

#include <gtest/gtest.h>

namespace gpvc {
namespace {

constexpr int kSide = 60;

// Squares of two triangles that face a camera at the origin, 60 x 60 px of a field of 90 degrees: faces 0 and 1 at 10, 2 and 3
// behind them at 20, 4 and 5 beside them at 10.
Mesh squares() {
  Mesh mesh;
  const auto add = [&](double x, double y, double z, double half) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const double dy : {-half, half})
      for (const double dx : {-half, half}) mesh.positions.push_back({x + dx, y + dy, z});
    mesh.faces.push_back({first, first + 2, first + 1});
    mesh.faces.push_back({first + 1, first + 2, first + 3});
  };
  add(-4, 0, 10, 3);
  add(-8, 0, 20, 1);
  add(5, 0, 10, 3);
  return mesh;
}

bool is_like(const Image& image, int x, int y, int red, int green, int blue) {
  const std::uint8_t* p = image.at(x, y);
  return std::abs(p[0] - red) < 30 && std::abs(p[1] - green) < 30 && std::abs(p[2] - blue) < 30;
}

TEST(MisfitPicture, HasDotsWherePlacesAreSeen) {
  const Image preview{kSide, kSide, 3, std::vector<std::uint8_t>(3 * kSide * kSide, 60)};
  pipeline::Viewpoint from;
  from.camera = {kSide, kSide, kSide / 2.0, kSide / 2.0, kSide / 2.0, kSide / 2.0, {}};
  const std::vector<atlas::CutMisfit::Place> places{
      {FaceId{0}, 0.0f}, {FaceId{2}, 5.0f}, {FaceId{4}, 3.0f}, {FaceId{5}, 1.0f}};
  const Image picture = pipeline::misfit_picture(squares(), preview, from, places);
  ASSERT_EQ(picture.width, kSide);
  EXPECT_TRUE(is_like(picture, 15, 27, 0, 220, 0));    // fits
  EXPECT_TRUE(is_like(picture, 42, 27, 220, 0, 0));    // far off
  EXPECT_TRUE(is_like(picture, 48, 33, 220, 220, 0));  // between
  EXPECT_TRUE(is_like(picture, 5, 5, 158, 158, 158));  // the preview, pale
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < 30; ++x) EXPECT_FALSE(is_like(picture, x, y, 220, 0, 0)) << x << ' ' << y;  // hidden
}

}  // namespace
}  // namespace gpvc
