#include "app/checks/sighting_shift.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/support/temporary_folder.h"

namespace gpvc::checks {
namespace {

using test::contains;

class SightingShifts : public testing::Test {
 protected:
  // Two photos of 400 x 300 of one camera, 10 m above points; a third of another.
  SightingShifts() {
    for (std::uint32_t v = 0; v < 3; ++v) {
      View& view = scene_.views.emplace_back();
      view.name = std::to_string(v) + ".jpg";
      view.camera = {400, 300, v < 2 ? 350.0 : 360.0, 350, 200, 150, {}};
      view.pose.centre = {0.5 * v, 0, -10};
    }
  }
  // What views show where `move` takes the places at which their cameras show the points, of those that are `kept`.
  std::vector<SightingShift> shifts(
      const std::function<PhotoPoint(ViewId, const PhotoPoint&)>& move,
      const std::function<bool(const PhotoPoint&)>& kept = [](const PhotoPoint&) { return true; }) const {
    std::vector<io::Sighting> sightings;
    for (std::uint32_t v = 0; v < 3; ++v)
      for (int i = 0; i < 100; ++i) {
        const WorldPoint p{-4 + 0.8 * (i % 10), -3 + 0.6 * (i / 10), 0.1 * (i % 7)};
        const View& view = scene_.views[v];
        const auto at = photo_from_pixel(view.camera, pixel_from_camera(view.camera, camera_from_world(view.pose, p)));
        if (kept(*at)) sightings.push_back({ViewId{v}, move(ViewId{v}, *at), p});
      }
    return sighting_shifts(scene_, sightings);
  }
  Scene scene_;
};

TEST_F(SightingShifts, AreFoundForEachCameraWithDirectionAndSize) {
  const auto found = shifts([](ViewId view, const PhotoPoint& at) {
    return index(view) < 2 ? PhotoPoint{at.x, at.y - 4} : at;
  });
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].view, ViewId{0});
  EXPECT_EQ(found[0].views, 2u);
  EXPECT_NEAR(found[0].right, 0, 1e-9);
  EXPECT_NEAR(found[0].down, -4, 1e-9);
  EXPECT_TRUE(contains(shift_text(scene_, found[0]),
                       "0.jpg and 1 more show their tie points 4.0 pixels above where their camera does"));
}

TEST_F(SightingShifts, OneViewOfManyThatIsWrongIsNoShift) {
  EXPECT_TRUE(shifts([](ViewId view, const PhotoPoint& at) {
                return index(view) == 0 ? PhotoPoint{at.x + (at.x > 200 ? 9 : -9), at.y} : at;
              }).empty());
}

TEST_F(SightingShifts, LessThanAPixelOfThePhotoIsLeftToPhotogrammetry) {
  const auto by = [](double pixels) {
    return [pixels](ViewId, const PhotoPoint& at) { return PhotoPoint{at.x + pixels, at.y}; };
  };
  EXPECT_TRUE(shifts(by(0.9)).empty());
  EXPECT_EQ(shifts(by(1.1)).size(), 2u);
  for (View& view : scene_.views) view.reduction = 4;
  EXPECT_EQ(shifts(by(0.3)).size(), 2u);
}

TEST_F(SightingShifts, AWrongFocalLengthIsToldWithItsSize) {
  const auto found = shifts([](ViewId view, const PhotoPoint& at) {
    return index(view) < 2 ? PhotoPoint{200 + (at.x - 200) / 1.2, 150 + (at.y - 150) / 1.2} : at;
  });
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].view, ViewId{0});
  EXPECT_NEAR(found[0].growth, -1 / 6.0, 1e-9);
  EXPECT_EQ(found[0].right, 0);
  EXPECT_TRUE(contains(shift_text(scene_, found[0]),
                       "0.jpg and 1 more show their tie points 16.7 % nearer to the principal point than their camera "
                       "does: the focal length is 20 % too long"));
}

// As in oblique photos, which show most points below the middle, or beside a lake.
TEST_F(SightingShifts, PointsOnOneSideOfThePhotoTellOfBoth) {
  const auto below_right = [](const PhotoPoint& at) { return at.y > 120 && at.x > 160; };
  const auto moved = shifts([](ViewId, const PhotoPoint& at) { return PhotoPoint{at.x - 6, at.y}; }, below_right);
  ASSERT_EQ(moved.size(), 1u) << "the other camera's are too few";
  EXPECT_EQ(moved[0].growth, 0);
  EXPECT_NEAR(moved[0].right, -6, 1e-9);
  const auto grown = shifts(
      [](ViewId, const PhotoPoint& at) {
        return PhotoPoint{200 + (at.x - 200) / 1.05, 150 + (at.y - 150) / 1.05};
      },
      below_right);
  ASSERT_EQ(grown.size(), 1u);
  EXPECT_NEAR(grown[0].growth, 1 / 1.05 - 1, 1e-9);
}

TEST_F(SightingShifts, PhotosOfAnotherSizeAreNoShift) {
  EXPECT_TRUE(shifts([](ViewId, const PhotoPoint& at) { return PhotoPoint{2 * at.x, 2 * at.y}; }).empty());
}

}  // namespace
}  // namespace gpvc::checks
