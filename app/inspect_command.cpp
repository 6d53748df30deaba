#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "app/scene_input.h"
#include "app/viewpoint.h"

namespace gpvc {
namespace {

struct Box {
  WorldPoint low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void add(const WorldPoint& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
};

std::string box_text(const Box& b) {
  return fmt::format("x {:.3f} .. {:.3f}, y {:.3f} .. {:.3f}, z {:.3f} .. {:.3f}", b.low.x, b.high.x, b.low.y,
                     b.high.y, b.low.z, b.high.z);
}

std::string camera_text(const Camera& c) {
  std::string text = fmt::format("{} x {} px, fx {:.2f} fy {:.2f} cx {:.2f} cy {:.2f}", c.width, c.height,
                                 c.fx, c.fy, c.cx, c.cy);
  const Distortion& d = c.distortion;
  if (d.is_identity()) return text + ", no distortion";
  return text +
         fmt::format(", k1 {:.5f} k2 {:.5f} p1 {:.5f} p2 {:.5f} k3 {:.5f}", d.k1, d.k2, d.p1, d.p2, d.k3);
}

void print_cameras(const Scene& scene, Console& console) {
  std::vector<std::pair<Camera, std::size_t>> cameras;
  Box centres;
  for (const View& view : scene.views) {
    centres.add(view.pose.centre);
    const auto known =
        std::find_if(cameras.begin(), cameras.end(), [&](const auto& c) { return c.first == view.camera; });
    if (known == cameras.end())
      cameras.emplace_back(view.camera, 1);
    else
      ++known->second;
  }
  console.result(fmt::format("views    {}, photos all there", scene.views.size()));
  for (const auto& [camera, count] : cameras)
    console.result(fmt::format("camera   {} views: {}", count, camera_text(camera)));
  console.result("cameras  " + box_text(centres));
}

// How many of the views have the corner in the frame, and the ground size of a pixel there; per vertex,
// thinned.
void print_mesh(const SceneInputData& in, Console& console) {
  const Mesh& mesh = in.mesh;
  Box box;
  for (const WorldPoint& p : mesh.positions) box.add(p);
  console.result(fmt::format("mesh     {} faces, {} vertices", readable_count(mesh.faces.size()),
                             readable_count(mesh.positions.size())));
  const MeshTopology topology = mesh_topology(mesh);
  console.result(fmt::format(
      "topology {} components, {} boundary edges in {} loops, {} non-manifold faces, {} degenerate faces, {} "
      "unused vertices",
      readable_count(topology.components), readable_count(topology.boundary_edges),
      readable_count(topology.boundary_loops), readable_count(topology.nonmanifold_faces),
      readable_count(topology.degenerate_faces), readable_count(topology.unused_vertices)));
  console.result("extent   " + box_text(box));

  constexpr std::size_t kVertices = 20000;
  const std::size_t step = std::max<std::size_t>(1, mesh.positions.size() / kVertices);
  std::vector<double> sampling;
  std::size_t looked_at = 0, framed = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); v += step, ++looked_at) {
    bool any = false;
    for (const ViewId id : in.used) {
      const View& view = in.scene.views[index(id)];
      const CameraPoint c = camera_from_world(view.pose, mesh.positions[v]);
      if (!(c.z > 0)) continue;
      const PixelPoint p = pixel_from_camera(view.camera, c);
      if (p.x < 0 || p.y < 0 || p.x > view.camera.width || p.y > view.camera.height) continue;
      any = true;
      sampling.push_back(c.z / view.camera.fx);
    }
    framed += any ? 1 : 0;
  }
  console.result(fmt::format(
      "in frame {:.1f} % of the vertices lie in some view's frame (occlusion not looked at)",
      100.0 * static_cast<double>(framed) / static_cast<double>(std::max<std::size_t>(looked_at, 1))));
  if (sampling.empty()) {
    console.warning("no vertex lies in any view's frame: are mesh and cameras in the same coordinates?");
    return;
  }
  std::nth_element(sampling.begin(), sampling.begin() + static_cast<std::ptrdiff_t>(sampling.size() / 2),
                   sampling.end());
  console.result(fmt::format("sampling {:.6g} units a pixel in the median", sampling[sampling.size() / 2]));
  console.result(fmt::format("up       {}", up_name(scene_up(in.scene, in.used))));
}

}  // namespace

void run_inspect(const InspectOptions& options, Console& console) {
  RunRecord record;
  if (!options.with_mesh) {
    print_cameras(read_scene(options.input.scene, options.input.reader_options()), console);
    return;
  }
  const SceneInputData in = read_scene_input(options.input, console, record);
  print_cameras(in.scene, console);
  print_mesh(in, console);
}

}  // namespace gpvc
