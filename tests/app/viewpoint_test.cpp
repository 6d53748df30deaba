// Where a model's coordinates start.
#include "app/pipeline/viewpoint.h"

#include <gtest/gtest.h>

namespace gpvc {
namespace {

// A slope of 200 x 200 m in UTM coordinates, under one camera 100 m above its middle.
class LocalOrigin : public testing::Test {
 protected:
  LocalOrigin() {
    constexpr std::uint32_t kSide = 41;
    for (std::uint32_t y = 0; y < kSide; ++y)
      for (std::uint32_t x = 0; x < kSide; ++x)
        mesh_.positions.push_back({448100.0 + 5 * x, 5411200.0 + 5 * y, 290.0 + 0.5 * x});
    for (std::uint32_t y = 0; y + 1 < kSide; ++y)
      for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
        const std::uint32_t at = y * kSide + x;
        mesh_.faces.push_back({at, at + 1, at + kSide});
        mesh_.faces.push_back({at + 1, at + kSide + 1, at + kSide});
      }
    labels_.assign(mesh_.faces.size(), ViewId{0});
    View view;
    view.camera.width = 3000;
    view.camera.height = 2000;
    view.camera.fx = view.camera.fy = 2000;
    view.pose.centre = {448200, 5411300, 400};
    scene_.views.push_back(view);
  }
  WorldPoint origin() const {
    const std::vector<ViewId> used{ViewId{0}};
    return pipeline::local_origin(mesh_, mesh_.positions, labels_, scene_, used);
  }

  Mesh mesh_;
  std::vector<ViewId> labels_;
  Scene scene_;
};

TEST_F(LocalOrigin, IsTheMiddleWhereFloatsAreTooCoarse) {
  EXPECT_EQ(origin(), (WorldPoint{448200, 5411300, 300}));
  for (WorldPoint& p : mesh_.positions) p = {p.x - 448200, p.y - 5411300, p.z};
  scene_.views[0].pose.centre = {0, 0, 400};
  EXPECT_EQ(origin(), WorldPoint{});
}

TEST_F(LocalOrigin, StrayCornersDoNotMoveIt) {
  mesh_.positions.push_back({0, 0, 0});  // of no face
  EXPECT_EQ(origin(), (WorldPoint{448200, 5411300, 300}));
  const auto stray = static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  mesh_.faces.push_back({0, 1, stray});
  labels_.push_back(kNoView);
  EXPECT_EQ(origin(), (WorldPoint{448200, 5411300, 300}));
  labels_.back() = ViewId{0};
  EXPECT_EQ(origin(), (WorldPoint{448200, 5411300, 300}));
}

}  // namespace
}  // namespace gpvc
