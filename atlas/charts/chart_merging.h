// Pieces of one photo that lie so close together that their margins would overlap share a chart.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "atlas/charts/triangle_spans.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// Box of positions in a frame's texels.
struct FrameBox {
  double x0 = std::numeric_limits<double>::infinity(), y0 = x0, x1 = -x0, y1 = -x0;
  void add(const TexelTriangle& t) {
    for (const auto& p : t) add_point(p.x, p.y);
  }
  void add(const FrameBox& other) {
    add_point(other.x0, other.y0);
    add_point(other.x1, other.y1);
  }
  /// Texels from the one that holds the lowest coordinate to the one that holds the highest.
  int width() const { return std::max(1, static_cast<int>(std::ceil(x1) - std::floor(x0))); }
  int height() const { return std::max(1, static_cast<int>(std::ceil(y1) - std::floor(y0))); }

 private:
  void add_point(double x, double y) {
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
};

/// Faces of one view that keep their places relative to one another.
struct FramePart {
  ViewId view{};
  double scale = 1;
  std::vector<std::uint32_t> faces;  ///< ascending
  FrameBox box;
};

enum class TexelSharing { allowed, forbidden };

/// Calls visit(y, first, last) for the texels whose centres a face covers, but for those on its border, which its
/// neighbour covers too.
template <typename Visit>
void covered_spans(const TexelTriangle& corners, Visit&& visit) {
  constexpr CellBox kEverywhere{-(1 << 28), -(1 << 28), 1 << 28, 1 << 28};
  // Projections carry errors around 1e-9 px, far below this.
  constexpr double kStrictlyInside = -1.0 / 4096;
  triangle_spans(corners, kStrictlyInside, kEverywhere, visit);
}

/// Unites parts of the same view and scale that come within about twice `closeness` texels of one another, as long as
/// the union's box `fits`, and, where sharing is forbidden, no texel centre lies in two of them. `corners` are
/// positions in the texels of the whole frame at the part's scale. The result is ordered by first face. O(texels / 16)
/// and, where sharing is forbidden, O(texels).
std::vector<FramePart> merge_close_parts(std::vector<FramePart> parts, std::span<const TexelTriangle> corners,
                                         int closeness, TexelSharing sharing,
                                         const std::function<bool(const FrameBox&)>& fits);

}  // namespace gpvc::atlas
