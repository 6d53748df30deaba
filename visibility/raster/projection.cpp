#include "visibility/raster/projection.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>

namespace gpvc::visibility {

void project_vertices(const Mesh& mesh, const Camera& camera, const Pose& pose, ProjectedMesh& projected) {
  const std::size_t count = mesh.positions.size();
  projected.vertices.resize(count);
  projected.positions.resize(count);
  std::atomic<bool> moderate{true};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096), [&](const auto& range) {
    bool all = true;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const ProjectedVertex v = project(camera, pose, mesh.positions[i]);
      projected.vertices[i] = v;
      projected.positions[i] = rounded_position(v);
      all = all && (v.z <= 0 || (v.z >= 1e-60 && v.z <= 1e60));
    }
    if (!all) moderate.store(false, std::memory_order_relaxed);
  });
  projected.moderate = moderate.load();
}

}  // namespace gpvc::visibility
