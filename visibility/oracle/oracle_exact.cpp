#include "visibility/oracle/oracle_exact.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gpvc::visibility::truth {
namespace {

using boost::multiprecision::cpp_int;

/// The leading 64 bits of an integer and the power of two they were divided by; the sign is kept.
struct Leading {
  long double value;
  int shift;
};

Leading leading(const cpp_int& integer) {
  if (integer.is_zero()) return {0, 0};
  const cpp_int size = abs(integer);
  const int bits = static_cast<int>(msb(size)) + 1, shift = std::max(0, bits - 64);
  const auto top = static_cast<long double>(static_cast<std::uint64_t>(cpp_int(size >> shift)));
  return {integer.sign() < 0 ? -top : top, shift};
}

/// A 3 x 3 determinant with rows a, b, c.
Dyadic determinant(const ExactPoint& a, const ExactPoint& b, const ExactPoint& c) {
  return a.x * (b.y * c.w - b.w * c.y) + a.y * (b.w * c.x - b.x * c.w) + a.w * (b.x * c.y - b.y * c.x);
}

ExactPoint projected(const View& view, const WorldPoint& p) {
  const auto& r = view.pose.rotation;
  const Dyadic dx = Dyadic(p.x) - Dyadic(view.pose.centre.x), dy = Dyadic(p.y) - Dyadic(view.pose.centre.y),
               dz = Dyadic(p.z) - Dyadic(view.pose.centre.z);
  const auto row = [&](std::size_t i) {
    return Dyadic(r[3 * i]) * dx + Dyadic(r[3 * i + 1]) * dy + Dyadic(r[3 * i + 2]) * dz;
  };
  const Dyadic z = row(2);
  const Camera& c = view.camera;
  return {Dyadic(c.fx) * row(0) + Dyadic(c.cx) * z, Dyadic(c.fy) * row(1) + Dyadic(c.cy) * z, z};
}

}  // namespace

Dyadic::Dyadic(double value) {
  constexpr int kBits = std::numeric_limits<double>::digits;
  mantissa_ = static_cast<std::int64_t>(std::ldexp(std::frexp(value, &exponent_), kBits));
  exponent_ -= kBits;
}

Dyadic Dyadic::operator+(const Dyadic& other) const {
  if (mantissa_.is_zero()) return other;
  if (other.mantissa_.is_zero()) return *this;
  const Dyadic &low = exponent_ < other.exponent_ ? *this : other, &high = &low == this ? other : *this;
  Dyadic sum;
  sum.mantissa_ = (high.mantissa_ << (high.exponent_ - low.exponent_)) + low.mantissa_;
  sum.exponent_ = low.exponent_;
  return sum;
}

Dyadic Dyadic::operator-(const Dyadic& other) const {
  Dyadic negative = other;
  negative.mantissa_ = -negative.mantissa_;
  return *this + negative;
}

Dyadic Dyadic::operator*(const Dyadic& other) const {
  Dyadic product;
  product.mantissa_ = mantissa_ * other.mantissa_;
  product.exponent_ = exponent_ + other.exponent_;
  return product;
}

long double Dyadic::ratio(const Dyadic& a, const Dyadic& b) {
  const Leading above = leading(a.mantissa_), below = leading(b.mantissa_);
  return std::ldexp(above.value / below.value, (above.shift + a.exponent_) - (below.shift + b.exponent_));
}

ExactPoint exact_position(double x, double y) { return {Dyadic(x), Dyadic(y), Dyadic(1)}; }

int compare(const ExactDepth& a, const ExactDepth& b) {
  return (a.numerator * b.denominator - b.numerator * a.denominator).sign();
}

long double relative_gap(const ExactDepth& a, const ExactDepth& b) {
  const Dyadic left = a.numerator * b.denominator, right = b.numerator * a.denominator;
  const Dyadic apart = left - right;
  return std::abs(Dyadic::ratio(apart, apart.sign() < 0 ? left : right));
}

ExactFace::ExactFace(const Mesh& mesh, const View& view, std::size_t face) {
  for (std::size_t k = 0; k < 3; ++k) vertices_[k] = projected(view, mesh.positions[mesh.faces[face][k]]);
  orientation_ = determinant(vertices_[0], vertices_[1], vertices_[2]).sign();
}

ExactFace::Coverage ExactFace::coverage(const ExactPoint& point) const {
  Coverage found{true, std::numeric_limits<long double>::infinity()};
  for (std::size_t k = 0; k < 3; ++k) {
    const ExactPoint &i = vertices_[(k + 1) % 3], &j = vertices_[(k + 2) % 3];
    // Gradient of the determinant (point, i, j) along x and y.
    const Dyadic along_x = i.y * j.w - i.w * j.y, along_y = i.w * j.x - i.x * j.w;
    const int side = determinant(point, i, j).sign() * orientation_;
    const int right = along_x.sign() * orientation_, below = along_y.sign() * orientation_;
    if (side < 0 || (side == 0 && !(right > 0 || (right == 0 && below > 0)))) found.inside = false;
    const long double slope = std::hypot(Dyadic::ratio(along_x, point.w), Dyadic::ratio(along_y, point.w));
    if (slope == 0) continue;  // the edge lies in the camera plane: nowhere on the image
    const Dyadic value = determinant(point, i, j);
    const Dyadic scale = point.w * point.w;
    found.margin_px = std::min(found.margin_px, orientation_ * Dyadic::ratio(value, scale) / slope);
  }
  return found;
}

ExactDepth ExactFace::depth(const ExactPoint& point) const {
  // The ray t * point meets the plane of the vertices where t = det(0, 1, 2) / sum of det(point, i, j).
  Dyadic sum;
  for (std::size_t k = 0; k < 3; ++k) sum = sum + determinant(point, vertices_[(k + 1) % 3], vertices_[(k + 2) % 3]);
  Dyadic volume = determinant(vertices_[0], vertices_[1], vertices_[2]);
  const Dyadic minus(-1.0);
  if (volume.sign() < 0) {
    volume = volume * minus;
    sum = sum * minus;
  }
  return {volume, sum, sum.sign() > 0};
}

}  // namespace gpvc::visibility::truth
