#include "visibility/raster/exact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

namespace gpvc::visibility {
namespace {

// --- expansions
// A number as a sum of non-overlapping, non-zero doubles, smallest first.

struct TwoTerms {
  double high, low;
};

TwoTerms two_sum(double a, double b) {
  const double sum = a + b, b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

TwoTerms two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

/// A number as an unevaluated sum of two doubles, the second at most half a unit in the last place of the first. Sums are
/// off by 3 r^2 of themselves, products by 7 r^2, quotients by less than 16 r^2, with r = 2^-53 (Joldes, Muller, Popescu 2017), as
/// long as nothing overflows or underflows.
class DoubleDouble {
 public:
  DoubleDouble() = default;
  DoubleDouble(double value) : high_(value) {}

  friend DoubleDouble operator-(const DoubleDouble& a) { return {-a.high_, -a.low_}; }
  friend DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
    const TwoTerms high = two_sum(a.high_, b.high_), low = two_sum(a.low_, b.low_);
    const TwoTerms sum = fast_two_sum(high.high, high.low + low.high);
    return normalized(sum.high, low.low + sum.low);
  }
  friend DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + -b; }
  friend DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
    const TwoTerms product = two_product(a.high_, b.high_);
    return normalized(product.high, product.low + (a.high_ * b.low_ + a.low_ * b.high_));
  }
  friend DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
    const double quotient = a.high_ / b.high_;
    const DoubleDouble rest = a - b * DoubleDouble(quotient);
    return normalized(quotient, rest.high_ / b.high_);
  }
  friend bool operator<(const DoubleDouble& a, const DoubleDouble& b) {
    return a.high_ < b.high_ || (a.high_ == b.high_ && a.low_ < b.low_);
  }
  friend bool operator>(const DoubleDouble& a, const DoubleDouble& b) { return b < a; }
  double rounded() const { return high_; }

 private:
  DoubleDouble(double high, double low) : high_(high), low_(low) {}
  static TwoTerms fast_two_sum(double a, double b) {
    const double sum = a + b;
    return {sum, b - (sum - a)};
  }
  static DoubleDouble normalized(double high, double low) {
    const TwoTerms sum = fast_two_sum(high, low);
    return {sum.high, sum.low};
  }

  double high_ = 0, low_ = 0;
};

class Expansion {
 public:
  Expansion() = default;
  explicit Expansion(double value) { add(value); }

  /// The sign of the largest term, which exceeds the others together.
  int sign() const { return terms_.empty() ? 0 : (terms_.back() > 0 ? 1 : -1); }

  friend Expansion operator+(Expansion a, const Expansion& b) {
    for (const double term : b.terms_) a.add(term);
    return a;
  }
  friend Expansion operator-(Expansion a, const Expansion& b) {
    for (const double term : b.terms_) a.add(-term);
    return a;
  }
  friend Expansion operator*(const Expansion& a, const Expansion& b) {
    Expansion result;
    for (const double x : a.terms_)
      for (const double y : b.terms_) {
        const TwoTerms terms = two_product(x, y);
        result.add(terms.low);
        result.add(terms.high);
      }
    return result;
  }

 private:
  /// Shewchuk's GROW-EXPANSION with zero elimination.
  void add(double value) {
    std::size_t kept = 0;
    for (const double term : terms_) {
      const TwoTerms sum = two_sum(value, term);
      value = sum.high;
      if (sum.low != 0) terms_[kept++] = sum.low;
    }
    terms_.resize(kept);
    if (value != 0) terms_.push_back(value);
  }

  std::vector<double> terms_;
};

/// EdgeValues of a face at a point, in another number type.
template <class Number>
struct Edges {
  std::array<Number, 3> a, b, e;
};

template <class Number>
Edges<Number> edges_at(const FacePoint& point) {
  Edges<Number> edges;
  const Number px(point.px), py(point.py);
  for (std::size_t k = 0; k < 3; ++k) {
    const ProjectedVertex& v = point.face->vertex[k];
    edges.a[k] = Number(v.u) - px * Number(v.z);
    edges.b[k] = Number(v.v) - py * Number(v.z);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    edges.e[k] = edges.a[j] * edges.b[i] - edges.a[i] * edges.b[j];
  }
  return edges;
}

/// LEF and TLR: the sign of the edge value or, on the edge, of its gradient along x, or else along y. Each callback
/// returns a sign as std::optional<int>, nothing when it cannot decide.
template <class Edge, class GradientX, class GradientY>
std::optional<bool> inside_by_signs(const Edge& edge, const GradientX& gradient_x, const GradientY& gradient_y) {
  std::optional<int> side = edge();
  if (side && *side == 0) side = gradient_x();
  if (side && *side == 0) side = gradient_y();
  if (!side) return std::nullopt;
  return *side > 0;
}

bool inside_by_expansions(const FacePoint& point, const Edges<Expansion>& edges, std::size_t k) {
  const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
  const Expansion zi(point.face->vertex[i].z), zj(point.face->vertex[j].z);
  const auto sign_of = [](const Expansion& value) { return std::optional<int>(value.sign()); };
  return *inside_by_signs([&] { return sign_of(edges.e[k]); },
                          [&] { return sign_of(zi * edges.b[j] - zj * edges.b[i]); },
                          [&] { return sign_of(zj * edges.a[i] - zi * edges.a[j]); });
}

bool covers_by_expansions(const FacePoint& point) {
  const auto edges = edges_at<Expansion>(point);
  for (std::size_t k = 0; k < 3; ++k)
    if (!inside_by_expansions(point, edges, k)) return false;
  return true;
}

/// The depth of each plane is z0 + n / s, see PlaneDepth.
int compare_by_expansions(const FacePoint& f, const FacePoint& g) {
  const auto plane = [](const FacePoint& point, Expansion& z0, Expansion& n, Expansion& s) {
    const auto edges = edges_at<Expansion>(point);
    const auto& v = point.face->vertex;
    z0 = Expansion(v[0].z);
    n = (Expansion(v[1].z) - z0) * edges.e[1] + (Expansion(v[2].z) - z0) * edges.e[2];
    s = edges.e[0] + edges.e[1] + edges.e[2];
  };
  Expansion zf, nf, sf, zg, ng, sg;
  plane(f, zf, nf, sf);
  plane(g, zg, ng, sg);
  return ((zf - zg) * (sf * sg) + nf * sg - ng * sf).sign();
}

// --- ties on a lattice
// Where corners lie on fractions of a pixel, many edges run through pixel centres, and every value is a double.

/// a x b as an unrounded pair, or nothing when a part may not be representable: the low part is a multiple of 2^-105 of
/// the product, so any product from 2^-969 to 2^1023 would be safe.
std::optional<TwoTerms> held_product(double a, double b) {
  const TwoTerms terms = two_product(a, b);
  if (a == 0 || b == 0) return TwoTerms{0, 0};
  if (!(std::abs(terms.high) > 0x1p-900 && std::abs(terms.high) < 0x1p1000)) return std::nullopt;
  return terms;
}

/// The sign of a x b - c x d, if both products are representable. Rounding is monotone, so the high parts order the
/// products, and the low parts do where the high parts are equal.
std::optional<int> sign_of_difference(double a, double b, double c, double d) {
  const auto p = held_product(a, b), q = held_product(c, d);
  if (!p || !q) return std::nullopt;
  const auto order = [](double x, double y) { return static_cast<int>(x > y) - static_cast<int>(x < y); };
  return p->high != q->high ? order(p->high, q->high) : order(p->low, q->low);
}

/// coordinate - position * depth, if a double represents it.
std::optional<double> held_difference(double coordinate, double position, double depth) {
  const auto product = held_product(position, depth);
  if (!product || product->low != 0) return std::nullopt;
  const TwoTerms difference = two_sum(coordinate, -product->high);
  if (!(difference.low == 0) || !std::isfinite(difference.high)) return std::nullopt;
  return difference.high;
}

/// A vertex as seen from a point.
struct SeenVertex {
  double a, b, z;
};

std::optional<SeenVertex> held_vertex(const FacePoint& point, std::size_t k) {
  const ProjectedVertex& v = point.face->vertex[k];
  const auto a = held_difference(v.u, point.px, v.z), b = held_difference(v.v, point.py, v.z);
  if (!a || !b) return std::nullopt;
  return SeenVertex{*a, *b, v.z};
}

/// LEF and TLR of the edge opposite vertex k, if doubles represent its ends as seen from the point.
std::optional<bool> inside_on_lattice(const FacePoint& point, std::size_t k) {
  const auto from = held_vertex(point, (k + 1) % 3), to = held_vertex(point, (k + 2) % 3);
  if (!from || !to) return std::nullopt;
  return inside_by_signs([&] { return sign_of_difference(to->a, from->b, from->a, to->b); },
                         [&] { return sign_of_difference(from->z, to->b, to->z, from->b); },
                         [&] { return sign_of_difference(to->z, from->a, from->z, to->a); });
}

/// covers_exactly(), if inside_on_lattice() decides every edge that the double filter leaves open, or finds one that
/// excludes the point.
std::optional<bool> covers_on_lattice(const FacePoint& point) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.values.e[k] > point.error) continue;
    const std::optional<bool> inside = inside_on_lattice(point, k);
    if (!inside || !*inside) return inside;
  }
  return true;
}

// --- filters

/// Upper bound of how far an operation is off, relative to its result.
template <class Real>
constexpr double kRoundoff = 0x1p-53;
template <>
constexpr double kRoundoff<DoubleDouble> = 0x1p-102;

/// Errors are doubles, whose own rounding is far below the factor of two that all bounds here contain.
double size_of(double value) { return std::abs(value); }
double size_of(const DoubleDouble& value) { return std::abs(value.rounded()); }

template <class Real>
double largest(const std::array<Real, 3>& v) {
  return std::max({size_of(v[0]), size_of(v[1]), size_of(v[2])});
}

/// A is rounded by at most da = r (|px z| + |A|), B likewise by db; the products of e carry 2 (a db + b da), their own
/// rounding 4 r a b. The factors below are twice that, for the terms of second order.
template <class Real>
double edge_error(const RasterFace& face, double px, double py, const std::array<Real, 3>& a,
                  const std::array<Real, 3>& b) {
  constexpr double r = kRoundoff<Real>;
  const double z = std::max({std::abs(face.vertex[0].z), std::abs(face.vertex[1].z), std::abs(face.vertex[2].z)});
  const double am = largest(a), bm = largest(b);
  const double da = r * (std::abs(px) * z + am), db = r * (std::abs(py) * z + bm);
  return 4 * (am * db + bm * da) + 8 * r * am * bm;
}

double edge_error(const FacePoint& point, const Edges<DoubleDouble>& edges) {
  return edge_error(*point.face, point.px, point.py, edges.a, edges.b);
}

/// True where the error of a result shows that nothing it came from overflowed, nor lost more to underflow than the
/// bounds of the errors, which are twice what they need be, allow. In pairs of doubles: the products of an edge value with
/// an error below 2^300 are below 2^402, and so are differences of depths in front of an error below 2^300, which makes
/// the products of both less than 2^804; what underflows is below 2^-1022, and below 2^-725 once it is divided by a sum of
/// edge values above 2^-297.
template <class Real>
bool in_range(double error) {
  return std::is_same_v<Real, double> || (error > 0x1p-300 && error < 0x1p300);
}

/// True when edge values with this error are certainly those of a covered point, false when certainly not.
template <class Real>
std::optional<bool> certainly_covers(const std::array<Real, 3>& e, double error) {
  if (!in_range<Real>(error)) return std::nullopt;
  if (e[0] > error && e[1] > error && e[2] > error) return true;
  if (e[0] < -error || e[1] < -error || e[2] < -error) return false;
  return std::nullopt;
}

template <class Real>
struct Depth {
  Real value;
  double error;
};

/// z0 + n / s, with n = dz1 e1 + dz2 e2 and s = e0 + e1 + e2, for non-negative e. With E the error of an e, dz the
/// larger |dz|, and s at least twice its own error 3 E + 3 r s: n / s is no larger than dz and off by at most dz (10 E
/// / s + 14 r); the sum rounds once more.
template <class Real>
Depth<Real> depth(const RasterFace& face, const std::array<Real, 3>& e, double edge_error) {
  constexpr double r = kRoundoff<Real>;
  const auto& v = face.vertex;
  const Real z0 = v[0].z, dz1 = Real(v[1].z) - z0, dz2 = Real(v[2].z) - z0;
  const Real s = e[0] + e[1] + e[2];
  if (!(s > 8 * edge_error) || !in_range<Real>(edge_error)) return {z0, std::numeric_limits<double>::infinity()};
  const Real value = z0 + (dz1 * e[1] + dz2 * e[2]) / s;
  const double dz = std::max(size_of(dz1), size_of(dz2));
  return {value, dz * (12 * edge_error / size_of(s) + 16 * r) + 2 * r * (size_of(value) + dz)};
}

template <class Real>
std::optional<int> compare(const Depth<Real>& f, const Depth<Real>& g) {
  const double margin = 2 * (f.error + g.error);
  if (!in_range<Real>(margin)) return std::nullopt;
  if (f.value < g.value - margin) return -1;
  if (f.value > g.value + margin) return 1;
  return std::nullopt;
}

bool same_vertex(const ProjectedVertex& a, const ProjectedVertex& b) { return a.u == b.u && a.v == b.v && a.z == b.z; }

bool same_triangle(const RasterFace& f, const RasterFace& g) {
  return std::all_of(f.vertex.begin(), f.vertex.end(), [&](const ProjectedVertex& p) {
    return same_vertex(p, g.vertex[0]) || same_vertex(p, g.vertex[1]) || same_vertex(p, g.vertex[2]);
  });
}

bool same_depth_everywhere(const RasterFace& f, const RasterFace& g) {
  const double z = f.vertex[0].z;
  const auto flat = [z](const ProjectedVertex& p) { return p.z == z; };
  return (std::all_of(f.vertex.begin(), f.vertex.end(), flat) && std::all_of(g.vertex.begin(), g.vertex.end(), flat)) ||
         same_triangle(f, g);
}

/// The first answer of a ladder of predicates, each slower than the one before and undecided less often. All but the
/// last return std::optional; the last always decides.
template <class First, class... Rest>
auto first_certain(const First& first, const Rest&... rest) {
  if constexpr (sizeof...(rest) == 0) {
    return first();
  } else {
    const auto answer = first();
    return answer ? *answer : first_certain(rest...);
  }
}

}  // namespace

FacePoint face_point(const RasterFace& face, double px, double py) {
  FacePoint point{&face, px, py, edge_values(face, px, py), 0};
  point.error = edge_error(face, px, py, point.values.a, point.values.b);
  return point;
}

bool covers_exactly(const FacePoint& point) {
  return first_certain([&] { return certainly_covers<double>(point.values.e, point.error); },
                       [&] { return covers_on_lattice(point); },
                       [&] {
                         const auto edges = edges_at<DoubleDouble>(point);
                         return certainly_covers<DoubleDouble>(edges.e, edge_error(point, edges));
                       },
                       [&] { return covers_by_expansions(point); });
}

int compare_depth_exactly(const FacePoint& f, const FacePoint& g) {
  return first_certain(
      [&] { return compare(depth<double>(*f.face, f.values.e, f.error), depth<double>(*g.face, g.values.e, g.error)); },
      [&] { return same_depth_everywhere(*f.face, *g.face) ? std::optional(0) : std::nullopt; },
      [&] {
        const auto of_f = edges_at<DoubleDouble>(f), of_g = edges_at<DoubleDouble>(g);
        return compare(depth<DoubleDouble>(*f.face, of_f.e, edge_error(f, of_f)),
                       depth<DoubleDouble>(*g.face, of_g.e, edge_error(g, of_g)));
      },
      [&] { return compare_by_expansions(f, g); });
}

}  // namespace gpvc::visibility
