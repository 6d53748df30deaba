#include "io/validate.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "io/finite.h"
#include "io/mesh.h"
#include "io/meshes/mesh_file.h"
#include "io/scene_members.h"

namespace gpvc {
namespace {

[[noreturn]] void refuse(const std::string& sentence) { throw InputError(sentence, {}); }

/// The first of so many things that is wrong; `count`: none.
template <typename IsWrong>
std::size_t first_wrong(std::size_t count, const IsWrong& is_wrong) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count, 65536), count,
      [&](const tbb::blocked_range<std::size_t>& range, std::size_t first) {
        for (std::size_t n = range.begin(); n < std::min(range.end(), first); ++n)
          if (is_wrong(n)) return n;
        return first;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

void check_places(const std::vector<WorldPoint>& positions, const char* what) {
  const std::size_t wrong = first_wrong(positions.size(), [&](std::size_t n) { return !io::has_place(positions[n]); });
  if (wrong < positions.size())
    refuse(fmt::format("the mesh: {} of vertex {} is ({}, {}, {}), expected numbers of at most {:.0e}", what, wrong,
                       positions[wrong].x, positions[wrong].y, positions[wrong].z, io::kMostCoordinate));
}

bool is_rotation(const std::array<double, 9>& r) {
  // What seven digits leave of a rotation, and a hundredfold: more is a scale, or no rotation at all.
  constexpr double kMost = 1e-4;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double product = r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2];
      if (!(std::abs(product - (i == j ? 1 : 0)) <= kMost)) return false;
    }
  return r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) + r[2] * (r[3] * r[7] - r[4] * r[6]) >
         0;
}

}  // namespace

void validate_faces(const Mesh& mesh) {
  const std::size_t vertices = mesh.positions.size(), faces = mesh.faces.size();
  constexpr std::size_t kMost = 0xFFFFFFFEu;  // the largest number means none
  if (vertices > kMost || faces > kMost)
    refuse(fmt::format("the mesh: has {} vertices and {} faces, expected at most {} of each", vertices, faces, kMost));
  const std::size_t wrong = first_wrong(faces, [&](std::size_t f) {
    return std::ranges::any_of(mesh.faces[f], [&](std::uint32_t v) { return v >= vertices; });
  });
  if (wrong < faces)
    refuse(fmt::format("the mesh: face {} names vertex {}, expected one of the {} that there are, from 0 on", wrong,
                       std::ranges::max(mesh.faces[wrong]), vertices));
}

void validate(const Mesh& mesh) {
  validate_faces(mesh);
  const std::size_t vertices = mesh.positions.size(), faces = mesh.faces.size();
  check_places(mesh.positions, "the position");
  check_places(mesh.file_positions, "the position in the file");
  if (!mesh.file_positions.empty() && mesh.file_positions.size() != vertices)
    refuse(fmt::format("the mesh: has {} positions in the file, expected one for each of {} vertices or none",
                       mesh.file_positions.size(), vertices));
  if (!mesh.source_face.empty() && mesh.source_face.size() != faces)
    refuse(fmt::format("the mesh: has {} source faces, expected one for each of {} faces or none",
                       mesh.source_face.size(), faces));
}

void validate(const View& view) {
  constexpr int kMostPixels = 1 << 16;
  constexpr double kLeastFocal = 1e-3, kMostFocal = 1e12;
  const Camera& c = view.camera;
  const auto fail = [&](const std::string& reason) { refuse(fmt::format("view '{}': {}", view.name, reason)); };
  if (c.width < 1 || c.height < 1 || c.width > kMostPixels || c.height > kMostPixels)
    fail(fmt::format("is {} x {} pixels large, expected 1 to {} each way", c.width, c.height, kMostPixels));
  for (const double focal : {c.fx, c.fy})
    if (!(focal >= kLeastFocal && focal <= kMostFocal))
      fail(fmt::format("has a focal length of {} pixels, expected {} to {:.0e}", focal, kLeastFocal, kMostFocal));
  for (const double centre : {c.cx, c.cy})
    if (!(std::abs(centre) <= kMostFocal))
      fail(fmt::format("has its principal point at {} pixels, expected a number up to {:.0e}", centre, kMostFocal));
  if (!io::is_finite(c.distortion)) fail("has a lens with a term that is no number");
  if (!is_rotation(view.pose.rotation))
    fail("has a rotation that is none: expected an orthonormal matrix without mirroring");
  if (!io::has_place(view.pose.centre))
    fail(fmt::format("stands at ({}, {}, {}), expected numbers of at most {:.0e}", view.pose.centre.x,
                     view.pose.centre.y, view.pose.centre.z, io::kMostCoordinate));
  if (view.reduction < 1) fail(fmt::format("has photos reduced {} times, expected 1 or more", view.reduction));
}

void validate(const Scene& scene, const Mesh& mesh, std::span<const ViewId> views) {
  validate(mesh);
  if (mesh.faces.empty()) refuse("the mesh: has no faces");
  if (views.empty()) refuse("the scene: no view is to be used, expected at least one");
  for (std::size_t n = 0; n < views.size(); ++n) {
    if (index(views[n]) >= scene.views.size())
      refuse(fmt::format("the scene: view {} is to be used, expected one of the {} that there are, from 0 on",
                         index(views[n]), scene.views.size()));
    if (n > 0 && views[n] <= views[n - 1])
      refuse(fmt::format("the scene: view {} is to be used after view {}, expected them in ascending order",
                         index(views[n]), index(views[n - 1])));
    validate(scene.views[index(views[n])]);
  }
}

void validate(const Scene& scene, const Mesh& mesh) { validate(scene, mesh, all_views(scene)); }

}  // namespace gpvc
