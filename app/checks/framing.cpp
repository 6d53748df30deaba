#include "app/checks/framing.h"

#include <tbb/parallel_for.h>

namespace gpvc::checks {
namespace {

/// Tests a point against the five planes of the view's frustum: through the four borders of the frame, and the camera's
/// own. The tests are linear in the point, so a convex hull is outside if all its corners are outside of one plane.
std::array<bool, 5> inside(const View& view, const WorldPoint& p) {
  const CameraPoint c = camera_from_world(view.pose, p);
  const Camera& k = view.camera;
  const double x = k.fx * c.x + k.cx * c.z, y = k.fy * c.y + k.cy * c.z;
  return {c.z > 0, x >= 0, y >= 0, x <= k.width * c.z, y <= k.height * c.z};
}

}  // namespace

std::array<WorldPoint, 8> corners(const Box& b) {
  std::array<WorldPoint, 8> out;
  for (std::size_t i = 0; i < 8; ++i)
    out[i] = {i & 1 ? b.high.x : b.low.x, i & 2 ? b.high.y : b.low.y, i & 4 ? b.high.z : b.low.z};
  return out;
}

bool hull_may_be_framed(const View& view, std::span<const WorldPoint> points) {
  std::array<bool, 5> any{};
  for (const WorldPoint& p : points) {
    const std::array<bool, 5> here = inside(view, p);
    for (std::size_t i = 0; i < any.size(); ++i) any[i] = any[i] || here[i];
  }
  return std::all_of(any.begin(), any.end(), [](bool plane) { return plane; });
}

bool may_be_framed(const View& view, const Mesh& mesh, const Triangle& face) {
  return hull_may_be_framed(
      view, std::array<WorldPoint, 3>{mesh.positions[face[0]], mesh.positions[face[1]], mesh.positions[face[2]]});
}

Mesh some_faces(const Mesh& mesh, std::size_t most, const View* view) {
  std::vector<std::size_t> framed;
  if (view != nullptr)
    FaceRuns(mesh).for_each_framed(*view, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f)
        if (may_be_framed(*view, mesh, mesh.faces[f])) framed.push_back(f);
    });
  const std::size_t all = view != nullptr ? framed.size() : mesh.faces.size(), count = std::min(most, all);
  Mesh some;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = i * all / count;
    const auto first = static_cast<std::uint32_t>(some.positions.size());
    for (const std::uint32_t v : mesh.faces[view != nullptr ? framed[at] : at])
      some.positions.push_back(mesh.positions[v]);
    some.faces.push_back({first, first + 1, first + 2});
  }
  return some;
}

FaceRuns::FaceRuns(const Mesh& mesh) : faces_(mesh.faces.size()), hulls_((faces_ + kRun - 1) / kRun) {
  tbb::parallel_for(std::size_t{0}, hulls_.size(), [&](std::size_t r) {
    hulls_[r] = corners(box_of_faces(mesh, r * kRun, std::min(faces_, (r + 1) * kRun)));
  });
}

}  // namespace gpvc::checks
