// World to homogeneous pixel coordinates, in double; the CPU twin of project() in shaders/raster.glsl.
//
// A vertex is kept as (u, v, z) with pixel = (u / z, v / z). Nothing is divided, so vertices behind the camera need no
// special case, and every value comes from +, - and x alone, which GLSL repeats bit for bit. Visibility is exact with
// respect to these triples: their rounding moves a pixel position by less than 16 * 2^-53 * (|fx| + |cx| + ...) px,
// about 1e-11 px for a photo of 8000 px.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "io/scene.h"

namespace gpvc::visibility {

struct ProjectedVertex {
  double u = 0, v = 0, z = 0;
};

inline ProjectedVertex project(const Camera& camera, const Pose& pose, const WorldPoint& world) {
  const CameraPoint p = camera_from_world(pose, world);
  return {camera.fx * p.x + camera.cx * p.z, camera.fy * p.y + camera.cy * p.z, p.z};
}

/// The pixel position of a vertex and the inverse of its depth, each rounded once: for bounds and for QuickFace. The
/// position is NaN when the vertex is not in front of the camera.
struct RoundedPosition {
  double x, y, per_z;
};

inline RoundedPosition rounded_position(const ProjectedVertex& v) {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  if (!(v.z > 0)) return {kNowhere, kNowhere, 0};
  // Far beyond any image, but finite.
  constexpr double kFar = 1e38;
  return {std::clamp(v.u / v.z, -kFar, kFar), std::clamp(v.v / v.z, -kFar, kFar), 1 / v.z};
}

/// All vertices of a mesh in one view.
struct ProjectedMesh {
  std::vector<ProjectedVertex> vertices;
  std::vector<RoundedPosition> positions;
  bool moderate = false;  ///< depths in front lie in [1e-60, 1e60]: no product of three overflows or underflows
};

/// Fills `projected`, reusing its memory. O(positions), TBB.
void project_vertices(const Mesh& mesh, const Camera& camera, const Pose& pose, ProjectedMesh& projected);

}  // namespace gpvc::visibility
