#include "app/checks/glance.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>

#include "io/vector.h"

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

class Glancer {
 public:
  Glancer(const View& view, Glance& glance) : view_(view), glance_(glance) {}

  void add(const Mesh& mesh, const Triangle& face) {
    std::array<WorldPoint, 3> p;  // in the camera's frame
    for (std::size_t i = 0; i < 3; ++i) {
      const CameraPoint c = camera_from_world(view_.pose, mesh.positions[face[i]]);
      p[i] = {c.x, c.y, c.z};
    }
    const bool crosses = p[0].z <= 0 || p[1].z <= 0 || p[2].z <= 0;  // reaches behind the camera
    if (crosses && !may_be_framed(view_, mesh, face)) return;
    const Camera& k = view_.camera;
    const Span columns =
        crosses ? Span{0, Glance::kColumns - 1} : span(p, &WorldPoint::x, k.fx, k.cx, k.width, Glance::kColumns);
    if (!(columns.first <= columns.last)) return;
    const Span rows =
        crosses ? Span{0, Glance::kRows - 1} : span(p, &WorldPoint::y, k.fy, k.cy, k.height, Glance::kRows);
    if (!(rows.first <= rows.last)) return;
    const WorldPoint a = cross(p[1], p[2]), b = cross(p[2], p[0]), c = cross(p[0], p[1]);
    const double volume = dot(p[0], a);  // < 0: the camera sees the front
    if (volume == 0) return;
    for (auto row = static_cast<std::size_t>(rows.first); row <= static_cast<std::size_t>(rows.last); ++row)
      for (auto column = static_cast<std::size_t>(columns.first); column <= static_cast<std::size_t>(columns.last);
           ++column) {
        const WorldPoint ray = Glance::ray(k, column, row);
        // The ray hits the face ahead of the camera if all three have the volume's sign.
        const double sign = volume > 0 ? 1 : -1;
        const double u = sign * dot(a, ray), v = sign * dot(b, ray), w = sign * dot(c, ray);
        if (!(u >= 0 && v >= 0 && w >= 0 && u + v + w > 0)) continue;
        const auto depth = static_cast<float>(sign * volume / (u + v + w));
        const std::size_t at = row * Glance::kColumns + column;
        // Of two coincident faces that are turned against each other, the front counts.
        if (!(depth < glance_.depths[at] || (depth == glance_.depths[at] && volume < 0))) continue;
        glance_.depths[at] = depth;
        glance_.backs[at] = volume > 0;
      }
  }

 private:
  // Columns or rows, whole numbers; empty when first > last.
  struct Span {
    double first, last;
  };

  static Span span(const std::array<WorldPoint, 3>& p, double WorldPoint::*axis, double focal, double centre, int size,
                   std::size_t count) {
    const auto end = static_cast<double>(count);
    double low = end, high = 0;
    for (const WorldPoint& corner : p) {
      const double at = (focal * (corner.*axis) / corner.z + centre) * end / size;
      low = std::min(low, at);
      high = std::max(high, at);
    }
    return {std::max(0.0, std::ceil(low - 0.5)), std::min(end - 1, std::floor(high - 0.5))};
  }

  const View& view_;
  Glance& glance_;
};

}  // namespace

void Box::add(const WorldPoint& p) {
  low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
  high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

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

Box box_of_faces(const Mesh& mesh, std::size_t begin, std::size_t end) {
  Box box;
  for (std::size_t f = begin; f != end; ++f)
    for (const std::uint32_t v : mesh.faces[f]) box.add(mesh.positions[v]);
  return box;
}

FaceRuns::FaceRuns(const Mesh& mesh) : faces_(mesh.faces.size()), hulls_((faces_ + kRun - 1) / kRun) {
  tbb::parallel_for(std::size_t{0}, hulls_.size(), [&](std::size_t r) {
    hulls_[r] = corners(box_of_faces(mesh, r * kRun, std::min(faces_, (r + 1) * kRun)));
  });
}

WorldPoint Glance::ray(const Camera& camera, std::size_t column, std::size_t row) {
  return {((static_cast<double>(column) + 0.5) * camera.width / kColumns - camera.cx) / camera.fx,
          ((static_cast<double>(row) + 0.5) * camera.height / kRows - camera.cy) / camera.fy, 1};
}

Glance glance_at(const Mesh& mesh, const FaceRuns& runs, const View& view) {
  Glance glance;
  glance.depths.assign(Glance::kColumns * Glance::kRows, std::numeric_limits<float>::infinity());
  glance.backs.assign(glance.depths.size(), false);
  Glancer glancer(view, glance);
  runs.for_each_framed(view, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) glancer.add(mesh, mesh.faces[f]);
  });
  return glance;
}

}  // namespace gpvc::checks
