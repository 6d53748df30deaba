#include "io/morton.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace gpvc {
namespace {

Box utm_box() {
  Box box;
  box.add({500'000, 5'400'000, 100});
  box.add({500'800, 5'400'400, 150});
  return box;
}

// Along each axis the curve ascends, and an eighth of the cube is left before the next one is entered.
TEST(Morton, EighthsFollowEachOther) {
  const MortonCurve curve(utm_box());
  const auto at = [&](double x, double y, double z) { return curve.at({500'000 + x, 5'400'000 + y, 100 + z}); };
  EXPECT_EQ(at(0, 0, 0), 0u);
  EXPECT_LT(at(100, 10, 10), at(101, 10, 10));
  EXPECT_LT(at(10, 100, 10), at(10, 101, 10));
  EXPECT_LT(at(10, 10, 30), at(10, 10, 31));
  // The cube's edge is 800: of all places with small y and z, those of its lower half along x come first.
  std::vector<std::uint64_t> near, far;
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) {
      near.push_back(at(49 * i, 49 * j, 0));
      far.push_back(at(401 + 49 * i, 49 * j, 0));
    }
  EXPECT_LT(std::ranges::max(near), std::ranges::min(far));
}

TEST(Morton, PlacesOutsideTheBoxHaveTheNearestCell) {
  const MortonCurve curve(utm_box());
  EXPECT_EQ(curve.at({0, 0, 0}), 0u);
  EXPECT_EQ(curve.at({1e9, 1e9, 1e9}), (std::uint64_t{1} << 63) - 1);
  EXPECT_EQ(curve.at({500'900, 5'400'000, 100}), curve.at({500'800, 5'400'000, 100}));
}

TEST(Morton, APointHasOnePlace) {
  Box box;
  box.add({3, 4, 5});
  EXPECT_EQ(MortonCurve(box).at({3, 4, 5}), 0u);
}

}  // namespace
}  // namespace gpvc
