#include "visibility/projection.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <limits>

namespace gpvc {

void project_vertices(const Mesh& mesh, const Camera& camera, const Pose& pose,
                      std::vector<ProjectedVertex>& projected) {
  projected.resize(mesh.positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.positions.size(), 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      projected[i] = project(camera, pose, mesh.positions[i]);
  });
}

void project_vertices(const Mesh& mesh, const Camera& camera, const Pose& pose, ProjectedMesh& projected) {
  const std::size_t count = mesh.positions.size();
  projected.vertices.resize(count);
  projected.positions.resize(count);
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const ProjectedVertex v = project(camera, pose, mesh.positions[i]);
      projected.vertices[i] = v;
      projected.positions[i] =
          v.z > 0 ? RoundedPosition{static_cast<float>(v.u / v.z), static_cast<float>(v.v / v.z)}
                  : RoundedPosition{kNowhere, kNowhere};
    }
  });
}

}  // namespace gpvc
