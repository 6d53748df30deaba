#include "visibility/classify/subpixel_positions.h"

#include <cstring>
#include <limits>

#include "io/wide_clones.h"
#include "visibility/raster/wide.h"

namespace gpvc::visibility {
namespace {

/// One lane a sample. The centroid is the sum of the vertices, with weight 3; a midpoint adds three times a vertex,
/// with weight 6.
GPVC_WIDE_CLONES void place_samples(const std::array<ProjectedVertex, 3>& v, SubpixelPositions& samples) {
  const FourDoubles all{1, 1, 1, 1};
  const FourDoubles u = all * (v[0].u + v[1].u + v[2].u) + 3 * FourDoubles{v[0].u, v[1].u, v[2].u, 0};
  const FourDoubles w = all * (v[0].v + v[1].v + v[2].v) + 3 * FourDoubles{v[0].v, v[1].v, v[2].v, 0};
  const FourDoubles z = all * (v[0].z + v[1].z + v[2].z) + 3 * FourDoubles{v[0].z, v[1].z, v[2].z, 0};
  const FourDoubles nowhere = FourDoubles{} + std::numeric_limits<double>::quiet_NaN();
  const FourDoubles px = z > 0 ? u / z : nowhere, py = w / z;
  std::memcpy(samples.x.data(), &px, sizeof(px));
  std::memcpy(samples.y.data(), &py, sizeof(py));
  std::memcpy(samples.weighted_z.data(), &z, sizeof(z));
}

}  // namespace

SubpixelPositions subpixel_positions(const PreparedView& view, FaceId face) {
  const Triangle& t = view.mesh.faces[index(face)];
  const auto& v = view.projected.vertices;
  SubpixelPositions samples;
  place_samples(nearest_first(v[t[0]], v[t[1]], v[t[2]]), samples);
  return samples;
}

}  // namespace gpvc::visibility
