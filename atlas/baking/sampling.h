// Colour of a photo at positions of its view's undistorted frame.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "io/image.h"
#include "io/scene.h"

namespace gpvc::atlas {

struct Color {
  float r = 0, g = 0, b = 0;
};

inline Color operator+(const Color& a, const Color& b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
inline Color operator-(const Color& a, const Color& b) { return {a.r - b.r, a.g - b.g, a.b - b.b}; }
inline Color operator*(const Color& a, const Color& b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
inline Color operator*(float s, const Color& a) { return {s * a.r, s * a.g, s * a.b}; }

inline std::uint8_t to_grey_level(float value) {
  return static_cast<std::uint8_t>(value <= 0 ? 0 : value >= 255 ? 255 : static_cast<int>(value + 0.5f));
}

inline void store(std::uint8_t* texel, const Color& c) {
  texel[0] = to_grey_level(c.r), texel[1] = to_grey_level(c.g), texel[2] = to_grey_level(c.b);
}

inline Color load(const std::uint8_t* texel) {
  return {static_cast<float>(texel[0]), static_cast<float>(texel[1]), static_cast<float>(texel[2])};
}

/// Catmull-Rom interpolation, the photo's border repeated outwards; within [0, 255] but for overshoot, which callers
/// clamp when they store.
Color sample_bicubic(const Image& photo, double x, double y);

/// Bilinear, borders repeated.
Color sample_bilinear(const Image& photo, double x, double y);

/// Step, in pixels, of a lattice between whose nodes photo_from_pixel may be interpolated bilinearly with an error
/// below kLatticeError; a power of two from 1 to 16. 16 for a camera without distortion.
int lattice_step(const Camera& camera);

inline constexpr double kLatticeError =
    0.01;  // px: a hundredth of a step of one pixel, under 1 grey level for steps under 100

/// photo_from_pixel over a rectangle of equally spaced frame positions, via the lattice.
class PhotoPositions {
 public:
  /// Positions x0 + i * step, y0 + j * step for 0 <= i, j <= cells; those in between are interpolated.
  PhotoPositions(const Camera& camera, double x0, double y0, double x1, double y1);
  /// nullopt beyond the fold of the lens model. \pre the position lies in the rectangle
  std::optional<PhotoPoint> at(double x, double y) const {
    if (!smooth_) return photo_from_pixel(*camera_, {x, y});
    const double u = (x - x0_) * inverse_width_, v = (y - y0_) * inverse_height_;
    return PhotoPoint{lerp(lerp(corners_[0].x, corners_[1].x, u), lerp(corners_[2].x, corners_[3].x, u), v),
                      lerp(lerp(corners_[0].y, corners_[1].y, u), lerp(corners_[2].y, corners_[3].y, u), v)};
  }

 private:
  static double lerp(double a, double b, double t) { return a + (b - a) * t; }
  const Camera* camera_;
  double x0_, y0_, inverse_width_, inverse_height_;
  std::array<PhotoPoint, 4> corners_;
  bool smooth_ = true;
};

}  // namespace gpvc::atlas
