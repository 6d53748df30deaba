#include "app/checks/mesh_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/support/grid_mesh.h"

namespace gpvc::checks {
namespace {

TEST(SmallPhoto, IsTheMeanOfWholeSquares) {
  Image photo{3001, 4, 3, {}};
  for (std::uint32_t i = 0; i < 3u * 3001 * 4; ++i)
    photo.pixels.push_back(static_cast<std::uint8_t>(i * 2654435761u >> 24));
  const SmallPhoto small = small_photo(photo);
  ASSERT_EQ(small.factor, 3);
  ASSERT_EQ(small.image.width, 1000);
  ASSERT_EQ(small.image.height, 1);
  for (int x = 0; x < small.image.width; ++x) {
    int sum = 0;
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        const std::uint8_t* rgb = photo.at(3 * x + i, j);
        sum += 77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2];
      }
    EXPECT_EQ(*small.image.at(x, 0), (sum + 9 * 128) / (9 * 256)) << x;
  }
}

// Two views above a plane of 20,000 faces, which see them from directions some 6 degrees apart; the second half of the faces
// has both views as candidates.
TEST(MeshFit, PlacesSpreadOverAllFacesThatTwoViewsSee) {
  const Mesh mesh = test::grid_mesh(100, 100, 0.01);
  Scene scene;
  scene.views.resize(2);
  scene.views[0].pose.centre = {0, 0, 10};
  scene.views[1].pose.centre = {1, 0, 10};
  const std::size_t faces = mesh.faces.size();
  const std::vector<SmallPhoto> photos(2, {1, {1, 1, 1, {0}}});
  const auto places_of = [&](std::size_t first, std::span<const SmallPhoto> shown) {
    labeling::CostTable candidates{{0}, {}, {}};
    for (std::size_t f = 0; f < faces; ++f) {
      candidates.views.push_back(0);
      if (f >= first) candidates.views.push_back(1);
      candidates.first.push_back(candidates.views.size());
    }
    candidates.costs.resize(candidates.views.size());
    return choose_places(mesh, scene, candidates, shown, {});
  };
  const auto face_of = [](const Place& place) { return index(place.face); };
  const std::vector<Place> places = places_of(faces / 2, photos);
  ASSERT_EQ(places.size(), 3072u);
  EXPECT_TRUE(std::ranges::is_sorted(places, {}, face_of));
  for (std::size_t part = 0; part < 10; ++part) {
    const auto first = std::ranges::lower_bound(places, faces / 2 + part * faces / 20, {}, face_of),
               end = std::ranges::lower_bound(places, faces / 2 + (part + 1) * faces / 20, {}, face_of);
    EXPECT_NEAR(static_cast<double>(end - first), 307.2, 3);
  }
  const std::vector<Place> few = places_of(faces - 7, photos);
  ASSERT_EQ(few.size(), 7u) << "all of them, where there are no more";
  EXPECT_EQ(face_of(few[0]), faces - 7);
  EXPECT_TRUE(places_of(0, std::vector<SmallPhoto>(2)).empty()) << "photos that are not looked at";
}

TEST(FitCounts, AreWholeNumbersOfPointsOnTheMeshOrOffIt) {
  FitGroups groups{};
  groups[3] = {7, 5, 4, 1};
  EXPECT_TRUE(are_counts(groups));
  for (const SurfaceCounts& wrong : {SurfaceCounts{7, 5, 4, 2},
                                     {4, 5, 4, 1},
                                     {7, 5, 6, -1},
                                     {7, 5, 4.5, 0.5},
                                     {7.5, 5, 4, 1},
                                     {1e300, 1e300, 1e300, 0},
                                     {-1, 0, 0, 0},
                                     {7, NAN, 4, 1},
                                     {INFINITY, 5, 4, 1}}) {
    groups[3] = wrong;
    EXPECT_FALSE(are_counts(groups)) << wrong.places << ' ' << wrong.found << ' ' << wrong.on_mesh;
  }
}

}  // namespace
}  // namespace gpvc::checks
