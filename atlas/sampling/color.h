// Colours as they are computed with.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "io/members.h"

namespace gpvc::atlas {

/// Typical difference of a place between photos that fit each other (noise, highlights), grey levels.
inline constexpr float kPhotoNoise = 3;

struct Color {
  float r = 0, g = 0, b = 0;
};
GPVC_MEMBERS(Color, r, g, b)

inline Color operator+(const Color& a, const Color& b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
inline Color operator-(const Color& a, const Color& b) { return {a.r - b.r, a.g - b.g, a.b - b.b}; }
inline Color operator*(const Color& a, const Color& b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
inline Color operator*(float s, const Color& a) { return {s * a.r, s * a.g, s * a.b}; }

/// A weighted mean of colours.
struct ColorMean {
  Color sum;
  float weight = 0;

  void add(const Color& color, float w = 1) {
    sum = sum + w * color;
    weight += w;
  }
  /// nullopt if nothing has been added.
  std::optional<Color> mean() const {
    if (!(weight > 0)) return std::nullopt;
    return (1 / weight) * sum;
  }
};

/// 0 for what is no number.
inline std::uint8_t to_grey_level(float value) {
  return static_cast<std::uint8_t>(value >= 255 ? 255 : value > 0 ? static_cast<int>(value + 0.5f) : 0);
}

inline void store(std::uint8_t* texel, const Color& c) {
  texel[0] = to_grey_level(c.r);
  texel[1] = to_grey_level(c.g);
  texel[2] = to_grey_level(c.b);
}

inline Color load(const std::uint8_t* texel) {
  return {static_cast<float>(texel[0]), static_cast<float>(texel[1]), static_cast<float>(texel[2])};
}

}  // namespace gpvc::atlas
