#include "io/color_difference.h"

#include <gtest/gtest.h>

namespace gpvc {
namespace {

// Pairs of table 1 of Sharma, Wu, Dalal 2005: blues, greys about which the mean hue jumps, far and near colours.
TEST(ColorDifference, AgreesWithPublishedPairs) {
  struct Pair {
    LabColor first, second;
    double difference;
  };
  for (const auto& [first, second, difference] : {Pair{{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
                                                  {{50, -1.3802, -84.2814}, {50, 0, -82.7485}, 1.0000},
                                                  {{50, 0, 0}, {50, -1, 2}, 2.3669},
                                                  {{50, 2.49, -0.0010}, {50, -2.49, 0.0009}, 7.1792},
                                                  {{50, 2.49, -0.0010}, {50, -2.49, 0.0011}, 7.2195},
                                                  {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
                                                  {{50, 2.5, 0}, {61, -5, 29}, 22.8977},
                                                  {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
                                                  {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082}}) {
    EXPECT_NEAR(color_difference(first, second), difference, 5e-5);
    EXPECT_NEAR(color_difference(second, first), difference, 5e-5);
    EXPECT_EQ(color_difference(first, first), 0);
  }
}

TEST(ColorDifference, LabOfSrgbIsThatOfTheStandard) {
  const auto expect = [](const std::array<float, 3>& rgb, const LabColor& lab) {
    const LabColor found = lab_from_srgb(rgb);
    EXPECT_NEAR(found.l, lab.l, 0.01);
    EXPECT_NEAR(found.a, lab.a, 0.01);
    EXPECT_NEAR(found.b, lab.b, 0.01);
  };
  expect({255, 255, 255}, {100, 0, 0});
  expect({0, 0, 0}, {0, 0, 0});
  expect({255, 0, 0}, {53.24, 80.09, 67.20});
  expect({0, 255, 0}, {87.73, -86.18, 83.18});
  expect({0, 0, 255}, {32.30, 79.19, -107.86});
  expect({119, 119, 119}, {50.03, 0, 0});
  expect({300, -5, 0}, {53.24, 80.09, 67.20});  // of a gain
}

}  // namespace
}  // namespace gpvc
