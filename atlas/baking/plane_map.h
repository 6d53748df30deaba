// Where a chart's texels lie in the frames of other views: through the plane of the face that owns them.
#pragma once

#include <array>
#include <optional>

#include "atlas/charts/charts.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// The world position of a texel (x, y) on its face's plane is base + (dx x + dy y + d1) / (wx x + wy y + w1), with a
/// positive denominator on the face.
struct PlaneMap {
  WorldPoint base, dx, dy, d1;
  double wx = 0, wy = 0, w1 = 1;
};

/// nullopt if the face has no area, or its plane contains the camera's centre.
std::optional<PlaneMap> plane_map(const Mesh& mesh, const Scene& scene, const ChartSet& set, std::uint32_t face);

/// Homography from a chart's texels to the frame of a view: matrix (x, y, 1) is (u w, v w, w), with w > 0 in front of
/// the camera.
struct FrameFromTexel {
  std::array<double, 9> matrix{};  ///< row-major

  /// nullopt behind the camera.
  std::optional<PixelPoint> operator()(double x, double y) const {
    const auto& m = matrix;
    const double w = m[6] * x + m[7] * y + m[8];
    if (!(w > 0)) return std::nullopt;
    return PixelPoint{(m[0] * x + m[1] * y + m[2]) / w, (m[3] * x + m[4] * y + m[5]) / w};
  }
};

FrameFromTexel frame_from_texel(const PlaneMap& map, const View& view);

}  // namespace gpvc::atlas
