#include "app/checks/mesh_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "io/vector.h"
#include "tests/support/grid_mesh.h"

namespace gpvc::checks {
namespace {

/// Hills of 4 m on a square of 40 m, and points on them.
class MeshShiftTest : public testing::Test {
 protected:
  MeshShiftTest() {
    for (WorldPoint& p : hills_.positions) p.z = 2 + std::sin(p.x / 3) + std::cos(p.y / 4 + p.x / 9);
  }

  /// For a mesh that is moved by `away`.
  std::optional<MeshShift> found(const WorldPoint& away) const {
    std::vector<io::TiePoint> points;
    for (std::size_t i = 0; i < hills_.positions.size(); i += 7) points.push_back({hills_.positions[i]});
    Mesh moved = hills_;
    for (WorldPoint& p : moved.positions) p = p + away;
    return find_shift(moved, points);
  }

  Mesh hills_ = test::grid_mesh(80, 80, 0.5);
};

TEST_F(MeshShiftTest, TellsAMoveWithinAFifthOfTheSize) {
  const auto shift = found({3, -5, 1});
  ASSERT_TRUE(shift);
  EXPECT_NEAR(shift->by.x, -3, 0.2);
  EXPECT_NEAR(shift->by.y, 5, 0.2);
  EXPECT_NEAR(shift->by.z, -1, 0.2);
  EXPECT_GT(shift->share, 0.8);
  EXPECT_LT(shift->share_as_is, 0.4);
}

// As heights above the geoid are against those above the ellipsoid.
TEST_F(MeshShiftTest, TellsHeightsThatAreOffByMoreThanTheSize) {
  for (const double off : {-48.3, 31.7, -18.0}) {
    const auto shift = found({0, 0, off});
    ASSERT_TRUE(shift) << off;
    EXPECT_NEAR(shift->by.x, 0, 0.2);
    EXPECT_NEAR(shift->by.y, 0, 0.2);
    EXPECT_NEAR(shift->by.z, -off, 0.2);
  }
}

TEST_F(MeshShiftTest, SaysNothingOfAMeshInItsPlaceOrElsewhere) {
  EXPECT_FALSE(found({0, 0, 0}));
  EXPECT_FALSE(found({300, 0, 0}));
}

}  // namespace
}  // namespace gpvc::checks
