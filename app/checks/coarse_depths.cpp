#include "app/checks/coarse_depths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "io/vector.h"
#include "visibility/item_buffer.h"

namespace gpvc::checks {
namespace {

/// The view with a camera whose pixels are the cells.
View view_of_cells(View view) {
  const Camera& c = view.camera;
  const double across = double{CoarseDepths::kColumns} / c.width, down = double{CoarseDepths::kRows} / c.height;
  view.camera = {
      CoarseDepths::kColumns, CoarseDepths::kRows, c.fx * across, c.fy * down, c.cx * across, c.cy * down, {}};
  return view;
}

/// False if the box around the face in the picture holds no middle of a pixel, as of most faces in a coarse one.
bool may_be_drawn(const View& view, const Mesh& mesh, const Triangle& face) {
  double left = view.camera.width, right = 0, top = view.camera.height, bottom = 0;
  for (const std::uint32_t v : face) {
    const auto q = pixel_from_world(view, mesh.positions[v]);
    if (!q) return may_be_framed(view, mesh, face);
    left = std::min(left, q->x);
    right = std::max(right, q->x);
    top = std::min(top, q->y);
    bottom = std::max(bottom, q->y);
  }
  const auto holds_middle = [](double low, double high, int size) {
    return std::ceil(std::max(low, 0.0) - 0.5) <= std::floor(std::min<double>(high, size) - 0.5);
  };
  return holds_middle(left, right, view.camera.width) && holds_middle(top, bottom, view.camera.height);
}

void add_faces(const Mesh& faces, const View& view, CoarseDepths& coarse) {
  const visibility::Ivm shown = visibility::draw_item_buffer(faces, view.camera, view.pose);
  for (std::size_t cell = 0; cell < shown.faces.size(); ++cell) {
    if (shown.faces[cell] == kNoFace) continue;
    std::array<WorldPoint, 3> p;  // in the camera's axes
    for (std::size_t i = 0; i < 3; ++i) {
      const CameraPoint c = camera_from_world(view.pose, faces.positions[faces.faces[index(shown.faces[cell])][i]]);
      p[i] = {c.x, c.y, c.z};
    }
    const WorldPoint normal = cross(p[1] - p[0], p[2] - p[0]);
    const double distance = dot(normal, p[0]);  // of the face's plane, times |normal|; < 0: the camera sees the front
    const WorldPoint ray = CoarseDepths::ray(view.camera, cell % CoarseDepths::kColumns, cell / CoarseDepths::kColumns);
    const auto depth = static_cast<float>(distance / dot(normal, ray));
    // Of two coincident faces that are turned against each other, the front counts.
    if (!(depth < coarse.depths[cell] || (depth == coarse.depths[cell] && distance < 0))) continue;
    coarse.depths[cell] = depth;
    coarse.backs[cell] = distance > 0;
  }
}

}  // namespace

WorldPoint CoarseDepths::ray(const Camera& camera, std::size_t column, std::size_t row) {
  return {((static_cast<double>(column) + 0.5) * camera.width / kColumns - camera.cx) / camera.fx,
          ((static_cast<double>(row) + 0.5) * camera.height / kRows - camera.cy) / camera.fy, 1};
}

CoarseDepths draw_coarse_depths(const Mesh& mesh, const FaceRuns& runs, const View& view) {
  CoarseDepths coarse;
  const View cells = view_of_cells(view);
  // A view may frame all of a mesh that hardly fits into the memory: its faces are copied and drawn in parts.
  constexpr std::size_t kFacesOfPart = std::size_t{1} << 18;
  Mesh part;
  const auto draw_part = [&] {
    if (!part.faces.empty()) add_faces(part, cells, coarse);
    part = {};
  };
  runs.for_each_framed(view, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      if (!may_be_drawn(cells, mesh, mesh.faces[f])) continue;
      const auto first = static_cast<std::uint32_t>(part.positions.size());
      for (const std::uint32_t v : mesh.faces[f]) part.positions.push_back(mesh.positions[v]);
      part.faces.push_back({first, first + 1, first + 2});
    }
    if (part.faces.size() >= kFacesOfPart) draw_part();
  });
  draw_part();
  return coarse;
}

}  // namespace gpvc::checks
