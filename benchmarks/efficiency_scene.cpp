// The scene that the efficiency tables are measured on when none is given: a generated relief.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "benchmarks/efficiency.h"

namespace gpvc::efficiency {
namespace {

constexpr int kCells = 553;
constexpr double kSide = 400;

/// In [0, 1), the same on every machine.
double noise(std::uint32_t a, std::uint32_t b) {
  std::uint32_t h = a * 0x9E3779B1U ^ (b + 0x7F4A7C15U) * 0x85EBCA77U;
  h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
  h = (h ^ (h >> 12)) * 0x297A2D39U;
  return static_cast<double>(h ^ (h >> 15)) / 4294967296.0;
}

double ground(double x, double y) {
  return 6 * std::sin(x / 47) * std::cos(y / 61) + 2.5 * std::sin(x / 13 + 1) * std::sin(y / 17) +
         0.6 * std::sin(x / 3.1) * std::cos(y / 2.7);
}

/// Blocks of 26 m with a building of 16 m on two out of three.
double building(double x, double y) {
  constexpr double kPitch = 26, kWidth = 16;
  const double column = std::floor(x / kPitch), row = std::floor(y / kPitch);
  const auto a = static_cast<std::uint32_t>(column), b = static_cast<std::uint32_t>(row);
  if (noise(a, b) > 0.67 || x - column * kPitch > kWidth || y - row * kPitch > kWidth) return 0;
  return 6 + 20 * noise(a + 1000, b);
}

Mesh relief() {
  constexpr double kStep = kSide / kCells;
  Mesh mesh;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const auto a = static_cast<std::uint32_t>(i), b = static_cast<std::uint32_t>(j);
      const double x = (i + 0.3 * noise(a, b + 5000)) * kStep, y = (j + 0.3 * noise(a + 5000, b)) * kStep;
      mesh.positions.push_back({x, y, ground(x, y) + building(x, y) + 0.05 * noise(a + 9000, b)});
    }
  const auto id = [](int i, int j) { return static_cast<std::uint32_t>(j * (kCells + 1) + i); };
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      mesh.faces.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
      mesh.faces.push_back({id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  return mesh;
}

/// A view of (x, y, 5) from `distance` away, in the direction `heading`, `tilt` off the vertical.
View looking_at(double x, double y, double heading, double tilt, double distance) {
  View view;
  view.camera = {4000, 3000, 3500, 3500, 2000 + 14.3, 1500 - 9.7, {}};
  const double sh = std::sin(heading), ch = std::cos(heading), st = std::sin(tilt), ct = std::cos(tilt);
  const std::array<double, 3> forward{ch * st, sh * st, -ct}, right{sh, -ch, 0};
  const std::array<double, 3> down{forward[1] * right[2] - forward[2] * right[1],
                                   forward[2] * right[0] - forward[0] * right[2],
                                   forward[0] * right[1] - forward[1] * right[0]};
  view.pose.rotation = {right[0], right[1], right[2], down[0], down[1], down[2], forward[0], forward[1], forward[2]};
  view.pose.centre = {x - distance * forward[0], y - distance * forward[1], 5 - distance * forward[2]};
  return view;
}

}  // namespace

BenchScene generated_scene() {
  BenchScene scene{"generated", relief(), {}};
  constexpr double kMiddle = kSide / 2, kHalfPi = 1.5707963267948966;
  for (int n = 0; n < 43; ++n) {
    const auto a = static_cast<std::uint32_t>(n);
    const double x = kMiddle + 120 * (noise(a, 1) - 0.5), y = kMiddle + 120 * (noise(a, 2) - 0.5);
    const bool nadir = n < 11;
    const double heading = nadir ? 6.28 * noise(a, 3) : (n % 4) * kHalfPi + 0.3 * (noise(a, 4) - 0.5);
    scene.views.push_back(looking_at(x, y, heading, nadir ? 0.02 + 0.05 * noise(a, 5) : 0.75, 290));
    scene.views.back().name = "view" + std::to_string(n);
  }
  return scene;
}

}  // namespace gpvc::efficiency
