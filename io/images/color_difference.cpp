#include "io/color_difference.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace gpvc {
namespace {

constexpr double kPi = std::numbers::pi;

/// Light of levels in steps of 1/16, at which its second derivative leaves errors below 1e-6 between the steps.
constexpr int kSteps = 16;
using LightTable = std::array<double, 255 * kSteps + 2>;

double light(float level) {
  static const LightTable kTable = [] {
    LightTable table;
    for (std::size_t i = 0; i < table.size(); ++i) table[i] = light_of_level(static_cast<double>(i) / kSteps);
    return table;
  }();
  const double at = std::clamp(static_cast<double>(level), 0.0, 255.0) * kSteps;
  const auto step = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(step);
  return kTable[step] * (1 - share) + kTable[step + 1] * share;
}

/// The cube root, continued by a line near 0.
double response(double t) {
  constexpr double kDelta = 6.0 / 29;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
}

double to_seventh(double v) { return v * v * v * v * v * v * v; }

/// In [0, 2 pi); 0 for greys.
double hue(double a, double b) {
  if (a == 0 && b == 0) return 0;
  const double h = std::atan2(b, a);
  return h < 0 ? h + 2 * kPi : h;
}

}  // namespace

double light_of_level(double level) {
  const double v = level / 255;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

LabColor lab_from_srgb(const std::array<float, 3>& rgb) {
  const double r = light(rgb[0]), g = light(rgb[1]), b = light(rgb[2]);
  const double x = response((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
  const double y = response(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
  const double z = response((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double color_difference(const LabColor& first, const LabColor& second) {
  const double chroma7 = to_seventh((std::hypot(first.a, first.b) + std::hypot(second.a, second.b)) / 2);
  const double kSeventh = to_seventh(25);
  const double stretch = 1 + 0.5 * (1 - std::sqrt(chroma7 / (chroma7 + kSeventh)));
  const double a1 = stretch * first.a, a2 = stretch * second.a;
  const double c1 = std::hypot(a1, first.b), c2 = std::hypot(a2, second.b);
  const double h1 = hue(a1, first.b), h2 = hue(a2, second.b);
  double turn = c1 * c2 == 0 ? 0 : h2 - h1;
  if (turn > kPi) turn -= 2 * kPi;
  if (turn < -kPi) turn += 2 * kPi;
  const double dl = second.l - first.l, dc = c2 - c1, dh = 2 * std::sqrt(c1 * c2) * std::sin(turn / 2);

  const double l = (first.l + second.l) / 2, c = (c1 + c2) / 2;
  double h = h1 + h2;
  if (c1 * c2 != 0) h = std::abs(h1 - h2) <= kPi ? h / 2 : h < 2 * kPi ? h / 2 + kPi : h / 2 - kPi;
  constexpr double kDegree = kPi / 180;
  const double t = 1 - 0.17 * std::cos(h - 30 * kDegree) + 0.24 * std::cos(2 * h) +
                   0.32 * std::cos(3 * h + 6 * kDegree) - 0.20 * std::cos(4 * h - 63 * kDegree);
  const double lightness2 = (l - 50) * (l - 50);
  const double sl = 1 + 0.015 * lightness2 / std::sqrt(20 + lightness2), sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
  const double from_blue = (h / kDegree - 275) / 25, c7 = to_seventh(c);
  const double rotation =
      -2 * std::sqrt(c7 / (c7 + kSeventh)) * std::sin(60 * kDegree * std::exp(-from_blue * from_blue));
  const double el = dl / sl, ec = dc / sc, eh = dh / sh;
  return std::sqrt(std::max(0.0, el * el + ec * ec + eh * eh + rotation * ec * eh));
}

}  // namespace gpvc
