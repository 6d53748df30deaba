#include "app/frame_check.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <atomic>

namespace gpvc {
namespace {

/// On the inner side of the four planes through the camera and its frame's borders, and of the camera's own;
/// linear in the point, so a convex hull is outside where all its corners are outside of one plane.
std::array<bool, 5> inside(const View& view, const WorldPoint& p) {
  const CameraPoint c = camera_from_world(view.pose, p);
  const Camera& k = view.camera;
  const double x = k.fx * c.x + k.cx * c.z, y = k.fy * c.y + k.cy * c.z;
  return {c.z > 0, x >= 0, y >= 0, x <= k.width * c.z, y <= k.height * c.z};
}

template <typename Points>
bool hull_may_be_framed(const View& view, const Points& points) {
  std::array<bool, 5> any{};
  for (const WorldPoint& p : points) {
    const std::array<bool, 5> here = inside(view, p);
    for (std::size_t i = 0; i < any.size(); ++i) any[i] = any[i] || here[i];
  }
  return std::all_of(any.begin(), any.end(), [](bool plane) { return plane; });
}

std::array<WorldPoint, 8> corners(const Box& b) {
  std::array<WorldPoint, 8> out;
  for (std::size_t i = 0; i < 8; ++i)
    out[i] = {i & 1 ? b.high.x : b.low.x, i & 2 ? b.high.y : b.low.y, i & 4 ? b.high.z : b.low.z};
  return out;
}

bool any_framed(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used) {
  std::atomic<bool> found{false};
  constexpr std::size_t kRun = 1024;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.faces.size(), kRun),
                    [&](const tbb::blocked_range<std::size_t>& run) {
                      if (found) return;
                      Box box;
                      for (std::size_t f = run.begin(); f != run.end(); ++f)
                        for (const std::uint32_t v : mesh.faces[f]) box.add(mesh.positions[v]);
                      const auto hull = corners(box);
                      for (const ViewId id : used) {
                        const View& view = scene.views[index(id)];
                        if (!hull_may_be_framed(view, hull)) continue;
                        for (std::size_t f = run.begin(); f != run.end() && !found; ++f)
                          if (may_be_framed(view, mesh, mesh.faces[f])) found = true;
                      }
                    });
  return found;
}

}  // namespace

void Box::add(const WorldPoint& p) {
  low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
  high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

Box box_of(const Mesh& mesh) {
  Box box;
  for (const WorldPoint& p : mesh.positions) box.add(p);
  return box;
}

Box box_of(const Scene& scene) {
  Box box;
  for (const View& view : scene.views) box.add(view.pose.centre);
  return box;
}

std::string box_text(const Box& b) {
  return fmt::format("x {:.3f} .. {:.3f}, y {:.3f} .. {:.3f}, z {:.3f} .. {:.3f}", b.low.x, b.high.x, b.low.y,
                     b.high.y, b.low.z, b.high.z);
}

bool may_be_framed(const View& view, const Mesh& mesh, const Triangle& face) {
  return hull_may_be_framed(view, std::array<WorldPoint, 3>{mesh.positions[face[0]], mesh.positions[face[1]],
                                                            mesh.positions[face[2]]});
}

void check_frames(const Mesh& mesh, const std::filesystem::path& mesh_file, const Scene& scene,
                  std::span<const ViewId> used) {
  if (used.empty() || any_framed(mesh, scene, used)) return;
  const auto hull = corners(box_of(mesh));
  const bool behind = std::all_of(used.begin(), used.end(), [&](ViewId id) {
    return std::none_of(hull.begin(), hull.end(), [&](const WorldPoint& p) {
      return camera_from_world(scene.views[index(id)].pose, p).z > 0;
    });
  });
  std::string text = fmt::format("no photo sees any face, the mesh lies {}: it spans {}, the cameras {}",
                                 behind ? "behind every camera" : "outside every frame",
                                 box_text(box_of(mesh)), box_text(box_of(scene)));
  const WorldPoint& o = scene.offset;
  if (!(o == WorldPoint{}))
    text += fmt::format(" (which is {} less {} {} {})", scene.srs.empty() ? "their system" : scene.srs, o.x,
                        o.y, o.z);
  else if (!scene.srs.empty())
    text += fmt::format(" (in {})", scene.srs);
  throw InputError(mesh_file, "", text + "; expected both in the same coordinates");
}

double framed_share(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used) {
  constexpr std::size_t kFaces = 100000;
  const std::size_t step = std::max<std::size_t>(1, mesh.faces.size() / kFaces);
  const std::size_t count = (mesh.faces.size() + step - 1) / step;
  const std::size_t framed = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count), std::size_t{0},
      [&](const tbb::blocked_range<std::size_t>& range, std::size_t sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          sum += std::any_of(used.begin(), used.end(), [&](ViewId id) {
            return may_be_framed(scene.views[index(id)], mesh, mesh.faces[i * step]);
          });
        return sum;
      },
      std::plus<>());
  return count == 0 ? 0 : static_cast<double>(framed) / static_cast<double>(count);
}

}  // namespace gpvc
