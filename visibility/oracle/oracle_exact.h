// Exact answers for the oracle: where the real numbers that the input's doubles stand for put a sample.
//
// A double is m * 2^e. Sums, differences and products of such numbers are such numbers, so with integers of any size
// nothing is ever rounded: not the camera's rotation, not the projection, not a determinant. A query costs some ten
// microseconds, so the oracle makes one only where doubles with error bounds cannot decide.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstdint>

#include "io/scene.h"

namespace gpvc::visibility::truth {

/// m * 2^e, without rounding.
class Dyadic {
 public:
  Dyadic() = default;
  /// \pre finite
  explicit Dyadic(double value);
  int sign() const { return mantissa_.sign(); }
  Dyadic operator+(const Dyadic& other) const;
  Dyadic operator-(const Dyadic& other) const;
  Dyadic operator*(const Dyadic& other) const;

  /// a / b, rounded to a relative error below 2^-60. \pre b is not 0
  static long double ratio(const Dyadic& a, const Dyadic& b);

 private:
  boost::multiprecision::cpp_int mantissa_;
  int exponent_ = 0;
};

/// A position on the image times w: (x, y, w); also a vertex as the camera sees it, with w its depth.
struct ExactPoint {
  Dyadic x, y, w;
};

/// The pixel position (x, y), unrounded.
ExactPoint exact_position(double x, double y);

/// A depth as a fraction of two numbers > 0, along a ray that both sides of a comparison share.
struct ExactDepth {
  Dyadic numerator, denominator;
  bool ahead = false;  ///< the ray meets the face's plane in front of the camera; else the fraction is meaningless
};

/// Sign of a - b.
int compare(const ExactDepth& a, const ExactDepth& b);
/// |a - b| / min(a, b), rounded.
long double relative_gap(const ExactDepth& a, const ExactDepth& b);

class ExactFace {
 public:
  ExactFace(const Mesh& mesh, const View& view, std::size_t face);

  /// -1 front-facing, 1 back-facing, 0 seen edge-on or degenerate.
  int orientation() const { return orientation_; }
  const std::array<ExactPoint, 3>& vertices() const { return vertices_; }

  struct Coverage {
    bool inside = false;        ///< top-left rule for a position exactly on an edge
    long double margin_px = 0;  ///< to the nearest edge's line, negative outside
  };
  /// \pre point.w > 0 and orientation() != 0
  Coverage coverage(const ExactPoint& point) const;
  ExactDepth depth(const ExactPoint& point) const;

 private:
  std::array<ExactPoint, 3> vertices_;
  int orientation_ = 0;
};

}  // namespace gpvc::visibility::truth
