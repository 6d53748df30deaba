#include "atlas/charts/texel_density.h"

#include <algorithm>
#include <cmath>

#include "io/vector.h"

namespace gpvc::atlas {

double pixel_size(const Mesh& mesh, std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners) {
  double world = 0, frame = 0;
  for (const auto face : faces) {
    const auto& t = mesh.faces[face];
    const WorldPoint& a = mesh.positions[t[0]];
    world += length(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a)) / 2;
    frame += std::abs(doubled_area(corners[face])) / 2;
  }
  return world > 0 && frame > 0 ? std::sqrt(world / frame) : 0;
}

double scale_for(double texel_size, double pixel_size) {
  constexpr double kSteps = 8;  // an octave
  if (!(texel_size > 0) || !(pixel_size > 0) || pixel_size >= texel_size) return 1;
  return std::min(1.0, std::exp2(std::ceil(kSteps * std::log2(pixel_size / texel_size)) / kSteps));
}

}  // namespace gpvc::atlas
