// What plain doubles call certain, against the exact predicates: on faces drawn at random, on faces whose corners and
// edges keep to pixel centres, and on slivers down to nothing.
#include "visibility/raster/quick_face.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "visibility/classify/face_sampler.h"
#include "visibility/raster/exact.h"

namespace gpvc::visibility {
namespace {

constexpr int kWidth = 60, kHeight = 50;
constexpr ProjectionRounding kRounding{250, 0.01};

/// Random corners: how far apart, how coarse the grid of positions that they keep to (0: none), how flat, and whether
/// two of them lie level up to rounding.
struct Kind {
  double size, grid, thickness;
  bool level = false;
};

class Corners {
 public:
  explicit Corners(std::uint32_t seed) : random_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_()) / 4294967296.0);
  }
  std::array<ProjectedVertex, 3> make(const Kind& kind) {
    const double x = uniform(2, kWidth - 2), y = uniform(2, kHeight - 2);
    const double angle = uniform(0, 6.2831853), along_x = std::cos(angle), along_y = std::sin(angle);
    std::array<ProjectedVertex, 3> corners;
    for (ProjectedVertex& v : corners) {
      const double a = uniform(-1, 1) * kind.size, b = uniform(-1, 1) * kind.size * kind.thickness;
      double px = x + a * along_x - b * along_y, py = y + a * along_y + b * along_x;
      if (kind.grid > 0) {
        px = std::round(px / kind.grid) * kind.grid;
        py = std::round(py / kind.grid) * kind.grid;
      }
      const double z = uniform(0.01, 100);
      v = {px * z, py * z, z};
    }
    if (kind.level) {
      const auto k = static_cast<std::size_t>(uniform(0, 3));
      ProjectedVertex& v = corners[(k + 1) % 3];
      v.v = corners[k].v / corners[k].z * v.z;
    }
    return corners;
  }

 private:
  std::mt19937 random_;
};

struct Prepared {
  explicit Prepared(const std::array<ProjectedVertex, 3>& c)
      : raster(raster_face(c[0], c[1], c[2], kRounding)),
        bounds(face_bounds(rounded_position(c[0]), rounded_position(c[1]), rounded_position(c[2]))),
        quick(QuickLimits(kWidth, kHeight, kRounding, true), rounded_position(c[0]), rounded_position(c[1]),
              rounded_position(c[2]), bounds) {}
  RasterFace raster;
  FaceBounds bounds;
  QuickFace quick;
};

constexpr PixelBox kFrame{0, 0, kWidth, kHeight};

/// Pixels from spans that may be in pieces.
std::vector<std::pair<int, int>> pixels(const std::vector<Span>& spans) {
  std::vector<std::pair<int, int>> found;
  for (const Span& span : spans)
    for (std::int32_t x = span.x0; x < span.x1; ++x) found.emplace_back(span.y, x);
  return found;
}

TEST(QuickFace, WhatIsCertainIsWhatTheExactPredicatesSay) {
  Corners corners(7);
  std::vector<Span> quick, exact;
  std::size_t certain = 0, ordinary = 0;
  for (const Kind& kind : {Kind{0.3, 0, 1}, Kind{2, 0, 1}, Kind{15, 0, 1}, Kind{60, 0, 1}, Kind{4, 0.5, 1},
                           Kind{4, 0.25, 1}, Kind{10, 0, 1e-3}, Kind{10, 0, 1e-9}, Kind{10, 0, 1e-13},
                           Kind{0.7, 0, 1, true}, Kind{8, 0, 1, true}, Kind{8, 0.5, 1, true}})
    for (int repeat = 0; repeat < 3000; ++repeat) {
      const Prepared face(corners.make(kind));
      const bool plain = kind.grid == 0 && kind.thickness == 1;
      ordinary += plain;
      if (face.quick.facing() != Facing::edge_on) {
        ASSERT_EQ(face.quick.facing(), face.raster.facing);
      }
      if (!face.quick.spans(pixel_centres(face.bounds, kFrame), quick)) continue;
      certain += plain;
      const SpanWalker walker(face.raster, pixel_bounds(face.raster, face.bounds, kFrame));
      collect_spans(face.raster, walker, true, exact);
      ASSERT_EQ(pixels(quick), pixels(exact)) << "size " << kind.size << " grid " << kind.grid;
      for (const Span& span : quick) ASSERT_LT(span.x0, span.x1);
    }
  EXPECT_GT(certain, ordinary * 99 / 100) << "quick answers are there for nearly all faces";
}

TEST(QuickFace, PointsThatAreInsideAreSoForTheExactPredicates) {
  Corners corners(8);
  std::size_t inside = 0;
  for (const Kind& kind : {Kind{0.5, 0, 1}, Kind{8, 0, 1}, Kind{8, 0.5, 1}, Kind{8, 0, 1e-6}})
    for (int repeat = 0; repeat < 4000; ++repeat) {
      const Prepared face(corners.make(kind));
      if (face.raster.facing == Facing::edge_on) continue;
      for (int k = 0; k < 8; ++k) {
        const double px = k < 4 ? corners.uniform(face.bounds.x0, face.bounds.x1)
                                : std::floor(corners.uniform(face.bounds.x0, face.bounds.x1)) + 0.5;
        const double py = k < 4 ? corners.uniform(face.bounds.y0, face.bounds.y1)
                                : std::floor(corners.uniform(face.bounds.y0, face.bounds.y1)) + 0.5;
        if (!face.quick.contains(px, py)) continue;
        ASSERT_TRUE(covers_exactly(face_point(face.raster, px, py)));
        ++inside;
      }
    }
  EXPECT_GT(inside, 10000U);
}

TEST(QuickFace, RowsHoldEveryPointOfTheFace) {
  Corners corners(9);
  std::size_t certain = 0, faces = 0;
  for (const Kind& kind : {Kind{0.5, 0, 1}, Kind{20, 0, 1}, Kind{20, 0, 1e-4}, Kind{8, 1, 1}})
    for (int repeat = 0; repeat < 3000; ++repeat) {
      const std::array<ProjectedVertex, 3> c = corners.make(kind);
      const Prepared face(c);
      const PixelBox box = touched_pixels(face.bounds, {-kWidth, -kHeight, 2 * kWidth, 2 * kHeight});
      RowCrossings edges;
      ++faces;
      if (!face.quick.cross(box, edges)) continue;
      ++certain;
      for (int k = 0; k < 6; ++k) {
        // A point of the face, corners and edges included.
        const double a = k == 0 ? 0 : corners.uniform(0, 1), b = k < 3 ? 0 : corners.uniform(0, 1 - a);
        const auto mix = [&](double p, double q, double r) { return p + a * (q - p) + b * (r - p); };
        const double x = mix(c[0].u / c[0].z, c[1].u / c[1].z, c[2].u / c[2].z) - box.x0 - 0.5;
        const double y = mix(c[0].v / c[0].z, c[1].v / c[1].z, c[2].v / c[2].z) - box.y0 - 0.5;
        const RowRange range = range_of_rows(edges, std::floor(y) - repeat % 60, std::floor(y) + 1);
        EXPECT_LE(range.low - edges.tolerance, x + 1e-9);
        EXPECT_GE(range.high + edges.tolerance, x - 1e-9);
      }
    }
  EXPECT_GT(certain, faces * 2 / 3);
}

TEST(QuickFace, DepthsThatAreCertainAreThoseOfTheExactPredicates) {
  Corners corners(11);
  std::size_t certain = 0, compared = 0, close = 0;
  for (const Kind& kind : {Kind{2, 0, 1}, Kind{15, 0, 1}, Kind{15, 0.5, 1}, Kind{15, 0, 1e-4}})
    for (int repeat = 0; repeat < 4000; ++repeat) {
      const std::array<ProjectedVertex, 3> c = corners.make(kind);
      std::array<ProjectedVertex, 3> d = corners.make(kind);
      // Every other time the same face a little farther away, down to less than a rounding.
      const double apart = 1 + std::pow(2, -corners.uniform(1, 60));
      if (repeat % 2 == 0)
        for (std::size_t k = 0; k < 3; ++k) d[k] = {c[k].u * apart, c[k].v * apart, c[k].z * apart};
      const Prepared f(c), g(d);
      const InverseDepth of_f = f.quick.inverse_depth(1 / c[0].z, 1 / c[1].z, 1 / c[2].z);
      const InverseDepth of_g = g.quick.inverse_depth(1 / d[0].z, 1 / d[1].z, 1 / d[2].z);
      for (int k = 0; k < 4; ++k) {
        const double px = corners.uniform(f.bounds.x0, f.bounds.x1);
        const double py = corners.uniform(f.bounds.y0, f.bounds.y1);
        if (!f.quick.contains(px, py) || !g.quick.contains(px, py)) continue;
        const int order = compare_depth_exactly(face_point(f.raster, px, py), face_point(g.raster, px, py));
        ++compared;
        if (of_f.before(of_g, px, py)) {
          ASSERT_LT(order, 0);
        }
        if (of_g.before(of_f, px, py)) {
          ASSERT_GT(order, 0);
        }
        const bool told = of_f.before(of_g, px, py) || of_g.before(of_f, px, py);
        certain += told;
        close += !told;
      }
    }
  EXPECT_GT(compared, 4000U);
  EXPECT_GT(certain, compared / 2);
  EXPECT_GT(close, 100U) << "the smallest distances cannot be told";
}

TEST(QuickFace, NothingIsCertainBeyondItsReach) {
  const std::array<ProjectedVertex, 3> c{ProjectedVertex{-1000, 3, 1}, ProjectedVertex{5, 40, 1},
                                         ProjectedVertex{9, 2, 1}};
  EXPECT_EQ(Prepared(c).quick.facing(), Facing::edge_on);
  EXPECT_EQ(Prepared({c[1], c[2], ProjectedVertex{4, 4, -1}}).quick.facing(), Facing::edge_on);
  const QuickLimits immoderate(kWidth, kHeight, kRounding, false);
  const Prepared near({ProjectedVertex{5, 4, 1}, ProjectedVertex{5, 40, 1}, ProjectedVertex{9, 2, 1}});
  EXPECT_NE(near.quick.facing(), Facing::edge_on);
  EXPECT_FALSE(immoderate.hold_for(near.bounds));
}

}  // namespace
}  // namespace gpvc::visibility
