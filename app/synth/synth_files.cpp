// A synthetic scene as files: mesh, cameras, photos, truth.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/synth/synth_scene.h"
#include "io/output_file.h"
#include "io/vector.h"

namespace gpvc::synth {
namespace {

// w, x, y, z of a rotation, w >= 0, from its largest component (Shepperd 1978).
std::array<double, 4> quaternion(const std::array<double, 9>& r) {
  const double squares[4] = {1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8],
                             1 - r[0] - r[4] + r[8]};
  int largest = 0;
  for (int i = 1; i < 4; ++i)
    if (squares[i] > squares[largest]) largest = i;
  const double s = std::sqrt(squares[largest]) * 2;  // 4 x the component
  std::array<double, 4> q{};
  if (largest == 0) q = {s / 4, (r[7] - r[5]) / s, (r[2] - r[6]) / s, (r[3] - r[1]) / s};
  if (largest == 1) q = {(r[7] - r[5]) / s, s / 4, (r[1] + r[3]) / s, (r[2] + r[6]) / s};
  if (largest == 2) q = {(r[2] - r[6]) / s, (r[1] + r[3]) / s, s / 4, (r[5] + r[7]) / s};
  if (largest == 3) q = {(r[3] - r[1]) / s, (r[2] + r[6]) / s, (r[5] + r[7]) / s, s / 4};
  if (q[0] < 0)
    for (double& v : q) v = -v;
  return q;
}

struct Observation {
  std::size_t point;
  PhotoPoint at;
};

struct TiePoint {
  WorldPoint position;
  Color color;
  std::vector<std::array<std::size_t, 2>> track;  // view, index among the view's observations
};

// Some face centroids that at least two views see, in place of the points that a feature matcher would find.
std::vector<TiePoint> tie_points(const SynthScene& scene, const std::vector<View>& views, const SynthRenderer& renderer,
                                 std::vector<std::vector<Observation>>& observations) {
  constexpr std::size_t kPoints = 1500;
  std::vector<TiePoint> points;
  observations.resize(views.size());
  for (std::uint32_t n = 0; n < kPoints; ++n) {
    const std::size_t face = synth_hash(n, 4711) % scene.mesh.faces.size();
    const Triangle& t = scene.mesh.faces[face];
    TiePoint point;
    for (const std::uint32_t v : t) {
      const WorldPoint& corner = scene.mesh.positions[v];
      point.position = point.position + WorldPoint{corner.x / 3, corner.y / 3, corner.z / 3};
    }
    point.color = surface_albedo(scene.surfaces[scene.face_surface[face]], point.position);
    std::vector<std::pair<std::size_t, PhotoPoint>> seen;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const auto at = photo_from_world(views[v], point.position);
      if (!at || at->x < 0 || at->y < 0 || at->x > views[v].camera.width || at->y > views[v].camera.height) continue;
      if (renderer.sees(views[v].pose, point.position, static_cast<std::uint32_t>(face))) seen.emplace_back(v, *at);
    }
    if (seen.size() < 2) continue;
    for (const auto& [v, at] : seen) {
      point.track.push_back({v, observations[v].size()});
      observations[v].push_back({points.size(), at});
    }
    points.push_back(point);
  }
  return points;
}

}  // namespace

void write_synth_mesh(const std::filesystem::path& file, const Mesh& mesh, const WorldPoint& offset) {
  const auto moved = [&](const WorldPoint& p) {
    const WorldPoint at = p + offset;
    return std::array<double, 3>{at.x, at.y, at.z};
  };
  const bool floats = std::all_of(mesh.positions.begin(), mesh.positions.end(), [&](const WorldPoint& p) {
    const auto at = moved(p);
    return std::all_of(at.begin(), at.end(), [](double v) { return static_cast<double>(static_cast<float>(v)) == v; });
  });
  io::OutputFile out(file);
  out.write(
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {0}\nproperty {2} x\nproperty {2} y\n"
                  "property {2} z\nelement face {1}\nproperty list uchar uint vertex_indices\nend_header\n",
                  mesh.positions.size(), mesh.faces.size(), floats ? "float" : "double"));
  const auto append = [&](auto value) { out.write(&value, sizeof value); };
  for (const WorldPoint& p : mesh.positions)
    for (const double v : moved(p))
      if (floats)
        append(static_cast<float>(v));
      else
        append(v);
  for (const Triangle& t : mesh.faces) {
    append(std::uint8_t{3});
    for (const std::uint32_t v : t) append(v);
  }
  out.commit();
}

std::vector<View> with_errors(std::vector<View> views, const CameraErrors& errors, std::uint32_t seed) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    View& view = views[v];
    Camera& camera = view.camera;
    const double corner = std::hypot(camera.width / 2.0 / camera.fx, camera.height / 2.0 / camera.fy);
    const auto number = static_cast<std::uint32_t>(v);
    // About an axis in the plane of the photo, which moves its middle, and about the view's own, which moves its corners.
    const double way = 2 * std::numbers::pi * synth_chance(seed, number, 8300);
    const double turn = (2 * synth_chance(seed, number, 8301) - 1) * errors.pose_px / (corner * camera.fx);
    const double tilt = errors.pose_px / camera.fx;
    const Eigen::Vector3d axis(std::cos(way) * tilt, std::sin(way) * tilt, turn);
    using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    Eigen::Map<Rotation> rotation(view.pose.rotation.data());
    if (errors.pose_px > 0) rotation = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix() * rotation;
    camera.distortion.k1 += errors.lens_px / (camera.fx * corner * corner * corner);
    limit_distortion(camera);
  }
  return views;
}

void write_synth_cameras(const std::filesystem::path& dir, const SynthScene& scene, const std::vector<View>& views,
                         const std::vector<View>& written, const SynthRenderer& renderer, const WorldPoint& offset) {
  std::vector<std::vector<Observation>> observations;
  const std::vector<TiePoint> points = tie_points(scene, views, renderer, observations);

  const Camera& camera = written.front().camera;
  std::string cameras = "# Camera list: CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  const Distortion& d = camera.distortion;
  if (d.is_identity())
    cameras += fmt::format("1 PINHOLE {} {} {} {} {} {}\n", camera.width, camera.height, camera.fx, camera.fy,
                           camera.cx, camera.cy);
  else
    cameras += fmt::format("1 OPENCV {} {} {} {} {} {} {} {} {} {}\n", camera.width, camera.height, camera.fx,
                           camera.fy, camera.cx, camera.cy, d.k1, d.k2, d.p1, d.p2);
  io::write_file(dir / "cameras.txt", cameras);

  std::string images =
      "# Image list, two lines each: IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME / POINTS2D[] as X, Y, "
      "POINT3D_ID\n";
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto q = quaternion(written[v].pose.rotation);
    Pose moved = written[v].pose;
    moved.centre = moved.centre + offset;
    const CameraPoint t = camera_from_world(moved, {});
    images +=
        fmt::format("{} {} {} {} {} {} {} {} 1 {}\n", v + 1, q[0], q[1], q[2], q[3], t.x, t.y, t.z, views[v].name);
    for (std::size_t i = 0; i < observations[v].size(); ++i)
      images += fmt::format("{}{:.3f} {:.3f} {}", i == 0 ? "" : " ", observations[v][i].at.x, observations[v][i].at.y,
                            observations[v][i].point + 1);
    images += "\n";
  }
  io::write_file(dir / "images.txt", images);

  std::string text = "# 3D point list: POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as IMAGE_ID, POINT2D_IDX\n";
  for (std::size_t n = 0; n < points.size(); ++n) {
    const TiePoint& p = points[n];
    text += fmt::format("{} {} {} {} {} {} {} 0", n + 1, p.position.x + offset.x, p.position.y + offset.y,
                        p.position.z + offset.z, static_cast<int>(p.color[0]), static_cast<int>(p.color[1]),
                        static_cast<int>(p.color[2]));
    for (const auto& [view, i] : p.track) text += fmt::format(" {} {}", view + 1, i);
    text += "\n";
  }
  io::write_file(dir / "points3D.txt", text);
}

void write_synth_surfaces(const std::filesystem::path& file, const SynthScene& scene) {
  const auto triple = [](const WorldPoint& p) { return nlohmann::ordered_json::array({p.x, p.y, p.z}); };
  nlohmann::ordered_json surfaces = nlohmann::ordered_json::array();
  for (const Surface& s : scene.surfaces)
    surfaces.push_back({{"material", name_of(kMaterialNames, s.material)},
                        {"origin", triple(s.origin)},
                        {"u_axis", triple(s.u_axis)},
                        {"v_axis", triple(s.v_axis)},
                        {"seed", s.seed},
                        {"windows", s.windows},
                        {"tint", s.tint},
                        {"scale", s.scale}});
  io::write_file(file, nlohmann::ordered_json{{"surfaces", surfaces}}.dump(1) + "\n");
}

}  // namespace gpvc::synth
