#include <cmath>

#include "atlas/alignment/alignment.h"

namespace gpvc::atlas {

Scene aligned_scene(const Scene& scene, std::span<const ShiftField> fields) {
  Scene aligned = scene;
  for (std::size_t v = 0; v < fields.size(); ++v) aligned.views[v].camera.distortion.aligned = fields[v];
  return aligned;
}

std::optional<std::array<double, 4>> inverse(const std::array<double, 4>& matrix) {
  const auto& [a, b, c, d] = matrix;
  const double determinant = a * d - b * c;
  constexpr double kLeast = 0.05;  // a pixel of one is less than a twentieth of one of the other
  if (!(std::abs(determinant) > kLeast)) return std::nullopt;
  return std::array{d / determinant, -b / determinant, -c / determinant, a / determinant};
}

std::array<double, 2> shift_by_fields(const AtlasInput& input, const SurfacePlace& place, ViewId other) {
  const Scene& scene = input.scene;
  const auto shift = [&](ViewId view, const PixelPoint& p) {
    const ShiftField& field = scene.views[index(view)].camera.distortion.aligned;
    return field.nodes.empty() ? std::array{0.0, 0.0} : field.shift_at(p);
  };
  const auto change = other_from_reference(input.mesh, scene, place, other);
  const auto back = change ? inverse(*change) : std::nullopt;
  const auto at = point_on_face(input.mesh, scene, place);
  const auto in_other = at ? pixel_from_world(scene.views[index(other)], *at) : std::nullopt;
  if (!back || !in_other) return {0, 0};
  const auto first = shift(place.reference, place.at), second = shift(other, *in_other);
  const auto& m = *back;
  return {m[0] * second[0] + m[1] * second[1] - first[0], m[2] * second[0] + m[3] * second[1] - first[1]};
}

}  // namespace gpvc::atlas
