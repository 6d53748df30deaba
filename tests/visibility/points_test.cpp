// Single points and faces of a mesh against whole views.
#include "visibility/points.h"

#include <gtest/gtest.h>

#include <random>

#include "io/photos.h"
#include "tests/visibility/visibility_oracle.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

ViewVisibility whole_view(const Mesh& mesh, const View& view, const io::PhotoExclusion* excluded = nullptr) {
  return VisibilityStage(mesh, {.method = Gpvc{.drawing = Drawing::native}}).classify(view, ViewId{}, excluded);
}

using Counts = std::array<std::size_t, 3>;  // of faces of each class

/// Each face alone has the class, and if it is partial the share, that it has in the whole view.
void expect_whole_view(const Mesh& mesh, const View& view, Counts& classes,
                       const io::PhotoExclusion* excluded = nullptr) {
  const ViewVisibility seen = whole_view(mesh, view, excluded);
  const PointStage points(mesh);
  std::vector<float> shares(mesh.faces.size(), 0);
  for (const FaceCoverage& entry : seen.coverage.entries) shares[index(entry.face)] = entry.visible_share;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const FaceSight alone = points.classify(FaceId{f}, view, excluded);
    ASSERT_EQ(alone.found, seen.classes[f]) << "face " << f;
    ASSERT_EQ(alone.visible_share, alone.found == FaceClass::full ? 1 : shares[f]) << "face " << f;
    ++classes[static_cast<std::size_t>(alone.found)];
  }
}

void expect_each_class(const Counts& classes) {
  for (const std::size_t count : classes) EXPECT_GT(count, 50U);
}

TEST(PointStage, ClassesAreThoseOfTheWholeView) {
  const View view = scenes::view_of(160, 120, 150);
  std::uint32_t seed = 300;
  Counts classes{};
  for (const double size : {0.3, 1.0, 5.0, 20.0})
    expect_whole_view(scenes::soup(view.camera, size < 5 ? 2000 : 500, size, seed++), view, classes);
  const View above = scenes::view_of(300, 300, 6000);
  for (const double gap : {0.01, 1.0, 100.0})
    expect_whole_view(scenes::layers(above.camera, 6100, gap, 12), above, classes);
  expect_each_class(classes);
}

TEST(PointStage, ClassesHoldForLensesMasksAndCamerasInsideTheMesh) {
  View view = scenes::view_of(160, 120, 150);
  view.camera.distortion.k1 = -0.3;
  limit_distortion(view.camera);
  io::PhotoExclusion mask{160, 120, 3, std::vector<std::uint64_t>(360, 0)};
  for (std::size_t y = 30; y < 70; ++y) mask.words[y * 3] = 0xFFFFFFFF00000000U;
  Counts classes{};
  expect_whole_view(scenes::soup(view.camera, 800, 8, 41), view, classes, &mask);
  const Mesh mesh = scenes::soup(scenes::view_of(160, 120, 150).camera, 500, 40, 42);
  for (const double angle : {0.3, 1.2, 2.5}) {
    View inside = scenes::view_of(160, 120, 90);
    inside.pose.rotation = scenes::rotation(angle, 0.4 - angle, 0.2);
    inside.pose.centre = {0.5, -0.3, 9};
    expect_whole_view(mesh, inside, classes);
  }
  expect_each_class(classes);
}

TEST(PointStage, PointsAtPixelCentresAreSeenWhereTheItemBufferHasTheirFace) {
  const View view = scenes::view_of(160, 120, 150);
  const Mesh mesh = scenes::soup(view.camera, 300, 30, 55);
  const ViewVisibility seen = whole_view(mesh, view);
  const PointStage points(mesh);
  std::size_t shown = 0, hidden = 0;
  std::mt19937 random(9);
  for (int n = 0; n < 40000; ++n) {
    const auto x = static_cast<int>(random() % 160), y = static_cast<int>(random() % 120);
    const auto face = static_cast<std::uint32_t>(random() % mesh.faces.size());
    const oracle::Corners corners = oracle::prepare(mesh, view, face).corners;
    const auto hit = oracle::meet(oracle::ray_of(view.camera, x + 0.5L, y + 0.5L), corners, 0);
    if (!hit || hit->margin_px < 1e-6L) continue;
    const auto depth = static_cast<double>(hit->depth);
    const auto point = points.nearest(scenes::at_pixel(view.camera, x + 0.5, y + 0.5, depth));
    ASSERT_TRUE(point);
    ASSERT_EQ(point->faces, std::vector{FaceId{face}});
    ASSERT_LT(point->distance, 1e-12);
    const PointSight sight = points.look(*point, view, nullptr);
    if (sight.sight == Sight::back) continue;
    ASSERT_NEAR(sight.photo->x, x + 0.5, 1e-9);
    const FaceId owner = seen.ivm.at(x, y);
    ASSERT_EQ(sight.sight == Sight::seen, owner == FaceId{face});
    ASSERT_EQ(sight.hidden_by, sight.sight == Sight::seen ? kNoFace : owner);
    ++(sight.sight == Sight::seen ? shown : hidden);
  }
  EXPECT_GT(shown, 20U);
  EXPECT_GT(hidden, 20U);
}

TEST(PointStage, SaysWhyAPointIsNotSeen) {
  View view = scenes::view_of(100, 100, 100);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{20, 20, 5}, {20, 80, 5}, {80, 20, 5}}});
  scenes::add_at_pixels(mesh, view.camera, {{{20, 20, 9}, {20, 80, 9}, {80, 20, 9}}});
  scenes::add_at_pixels(mesh, view.camera, {{{200, 20, 5}, {200, 80, 5}, {260, 20, 5}}});
  scenes::add_at_pixels(mesh, view.camera, {{{60, 90, 5}, {90, 60, 5}, {90, 90, 5}}});  // clockwise
  const PointStage points(mesh);
  const auto sight = [&](std::uint32_t face, const io::PhotoExclusion* excluded = nullptr) {
    return points.look(points.middle(FaceId{face}), view, excluded);
  };
  EXPECT_EQ(sight(0).sight, Sight::seen);
  EXPECT_EQ(sight(1).sight, Sight::hidden);
  EXPECT_EQ(sight(1).hidden_by, FaceId{0});
  EXPECT_EQ(sight(2).sight, Sight::outside_frame);
  EXPECT_TRUE(sight(2).photo) << "where it would be";
  EXPECT_EQ(sight(3).sight, Sight::back);
  const io::PhotoExclusion mask{100, 100, 2, std::vector<std::uint64_t>(200, ~std::uint64_t{0})};
  EXPECT_EQ(sight(0, &mask).sight, Sight::masked);
  view.camera.distortion.k1 = 300;  // beyond the photo
  limit_distortion(view.camera);
  EXPECT_EQ(sight(0).sight, Sight::outside_photo);
  view.pose.rotation = scenes::rotation(0, 3.14159, 0);
  EXPECT_EQ(sight(0).sight, Sight::behind);
  EXPECT_FALSE(sight(0).frame);
}

// Faces around a corner do not hide it from each other, far from the origin where coordinates are coarse.
TEST(PointStage, CornersAndEdgesAreSeenWithTheFacesAroundThem) {
  const View near = scenes::view_of(200, 200, 200);
  Mesh mesh =
      scenes::terrain(near.camera, 6, 6, 20, 20, 25, 10, [](int i, int j) { return 10 + 0.3 * ((i * 7 + j * 3) % 5); });
  View view = near;
  const WorldPoint far{512345.25, 5400000.5, 300};
  for (WorldPoint& p : mesh.positions) p = {p.x + far.x, p.y + far.y, p.z + far.z};
  view.pose.centre = far;
  const PointStage points(mesh);
  std::size_t seen = 0, several = 0;
  for (const WorldPoint& corner : mesh.positions) {
    const auto point = points.nearest(corner);
    ASSERT_TRUE(point);
    EXPECT_LT(point->distance, 1e-8);
    several += point->faces.size() > 1 ? 1 : 0;
    const PointSight sight = points.look(*point, view, nullptr);
    EXPECT_EQ(std::ranges::find(point->faces, sight.hidden_by), point->faces.end()) << "hidden by a face of its own";
    seen += sight.sight == Sight::seen ? 1 : 0;
  }
  EXPECT_GT(several, 30U);
  EXPECT_GT(seen, 20U);
}

TEST(PointStage, AnEmptyMeshHasNoPoint) {
  const Mesh mesh;
  EXPECT_FALSE(PointStage(mesh).nearest({0, 0, 0}));
}

}  // namespace
}  // namespace gpvc::visibility
