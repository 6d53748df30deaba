// Scenes for other programs. Each format's conventions are stated where it is read: colmap_scene.cpp, cam_scene.cpp,
// openmvs_scene.cpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <utility>

#include "io/output_file.h"
#include "io/scene_files.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

/// Shortest text that reads back as the same double.
std::string digits(double value) {
  std::array<char, 40> text{};
  for (int precision = 15; precision <= 17; ++precision) {
    std::snprintf(text.data(), text.size(), "%.*g", precision, value);
    if (std::strtod(text.data(), nullptr) == value) break;
  }
  return text.data();
}

std::string joined(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += ' ';
    text += digits(value);
  }
  return text;
}

void write_text(const fs::path& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

WorldPoint rotated(const std::array<double, 9>& r, const WorldPoint& p) {
  return {r[0] * p.x + r[1] * p.y + r[2] * p.z, r[3] * p.x + r[4] * p.y + r[5] * p.z,
          r[6] * p.x + r[7] * p.y + r[8] * p.z};
}

/// t of x_camera = R x_world + t.
WorldPoint translation(const Pose& pose) {
  const WorldPoint c = rotated(pose.rotation, pose.centre);
  return {-c.x, -c.y, -c.z};
}

// --- what a lens has, and what a format can say

struct Term {
  const char* name;
  double value;
};

/// The first term that is not zero.
std::optional<std::string> first_of(std::initializer_list<Term> terms) {
  for (const Term& term : terms)
    if (term.value != 0) return std::string(term.name);
  return std::nullopt;
}

const char* projection_name(LensModel model) {
  switch (model) {
    case LensModel::brown:
    case LensModel::perspective:
      return "perspective";
    case LensModel::equidistant:
      return "equidistant (fisheye)";
    case LensModel::equisolid:
      return "equisolid (fisheye)";
    case LensModel::fov:
      return "field-of-view";
    case LensModel::inverse_radial:
      return "inverse radial";
    case LensModel::division:
      return "division";
    case LensModel::unified:
      return "unified";
    case LensModel::fisheye_624:
      return "equidistant (fisheye)";
  }
  return "unknown";
}

bool is_perspective(LensModel model) { return model == LensModel::brown || model == LensModel::perspective; }

struct ColmapLens {
  const char* model;
  std::string terms;
};

/// nullopt when `lost` names what COLMAP has no place for.
std::optional<ColmapLens> colmap_lens(const Camera& c, std::string& lost) {
  const Distortion& d = c.distortion;
  const auto with = [&](const char* model, std::initializer_list<double> terms) {
    std::string all = joined({c.fx, c.fy, c.cx, c.cy});
    for (const double term : terms) all.append(1, ' ').append(digits(term));
    return ColmapLens{model, all};
  };
  const auto refuse = [&lost](const std::optional<std::string>& term) {
    if (term) lost = *term;
    return term.has_value();
  };
  if (is_perspective(d.model)) {
    if (refuse(first_of({{"k4", d.k4}, {"p3", d.p3}, {"p4", d.p4}, {"s1", d.s1}, {"s2", d.s2}, {"skew", d.skew}})))
      return std::nullopt;
    if (first_of({{"", d.k3}, {"", d.d1}, {"", d.d2}, {"", d.d3}}))
      return with("FULL_OPENCV", {d.k1, d.k2, d.p1, d.p2, d.k3, d.d1, d.d2, d.d3});
    if (d.is_identity()) return with("PINHOLE", {});
    return with("OPENCV", {d.k1, d.k2, d.p1, d.p2});
  }
  if (d.model == LensModel::equidistant) {
    if (refuse(first_of({{"d1", d.d1},
                         {"d2", d.d2},
                         {"d3", d.d3},
                         {"p3", d.p3},
                         {"p4", d.p4},
                         {"skew", d.skew},
                         {"k5", d.k5},
                         {"k6", d.k6},
                         {"s3", d.s3},
                         {"s4", d.s4}})))
      return std::nullopt;
    if (first_of({{"", d.p1}, {"", d.p2}, {"", d.s1}, {"", d.s2}}))
      return with("THIN_PRISM_FISHEYE", {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.s1, d.s2});
    return with("OPENCV_FISHEYE", {d.k1, d.k2, d.k3, d.k4});
  }
  if (d.model == LensModel::fov) {
    if (refuse(first_of({{"skew", d.skew}}))) return std::nullopt;
    return with("FOV", {d.omega});
  }
  if (d.model == LensModel::division) return with("DIVISION", {d.k1});
  if (d.model == LensModel::unified) return with("EUCM", {d.alpha, d.beta});
  if (d.model == LensModel::fisheye_624)
    return with("RAD_TAN_THIN_PRISM_FISHEYE", {d.k1, d.k2, d.k3, d.k4, d.k5, d.k6, d.p2, d.p1, d.s1, d.s3, d.s2, d.s4});
  lost = std::string("the ") + projection_name(d.model) + " projection";
  return std::nullopt;
}

std::optional<std::string> lost_in_pinhole(const Distortion& d) {
  if (d.is_identity()) return std::nullopt;
  if (!is_perspective(d.model)) return std::string("the ") + projection_name(d.model) + " projection";
  return first_of({{"k1", d.k1},
                   {"k2", d.k2},
                   {"k3", d.k3},
                   {"k4", d.k4},
                   {"p1", d.p1},
                   {"p2", d.p2},
                   {"d1", d.d1},
                   {"d2", d.d2},
                   {"d3", d.d3},
                   {"s1", d.s1},
                   {"s2", d.s2},
                   {"skew", d.skew}});
}

/// Radial terms alone, about the photo's middle, with square pixels; k1 without k2 means another model there.
std::optional<std::string> lost_in_cam(const Camera& c) {
  const Distortion& d = c.distortion;
  if (!lost_in_pinhole(d)) return std::nullopt;
  const bool radial = is_perspective(d.model) && d.k1 != 0 && d.k2 != 0;
  if (!radial && d.model != LensModel::inverse_radial) {
    if (is_perspective(d.model) && (d.k1 != 0) != (d.k2 != 0))
      return std::string(d.k1 != 0 ? "k1 without k2" : "k2 without k1");
    return lost_in_pinhole(d);
  }
  if (const auto more = first_of({{"k3", d.k3},
                                  {"k4", d.k4},
                                  {"p1", d.p1},
                                  {"p2", d.p2},
                                  {"d1", d.d1},
                                  {"d2", d.d2},
                                  {"d3", d.d3},
                                  {"s1", d.s1},
                                  {"s2", d.s2},
                                  {"skew", d.skew}}))
    return more;
  if (c.fx != c.fy) return "fx apart from fy, with distortion";
  if (2 * c.cx != c.width || 2 * c.cy != c.height) return "a principal point off the middle, with distortion";
  return std::nullopt;
}

// --- COLMAP

/// w x y z of a rotation matrix, the largest of the four first (Shepperd 1978).
std::array<double, 4> quaternion(const std::array<double, 9>& r) {
  const std::array<double, 4> squares{1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8],
                                      1 - r[0] - r[4] + r[8]};
  const auto largest = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  const double twice = std::sqrt(squares[largest]);
  std::array<double, 4> q{r[7] - r[5], r[2] - r[6], r[3] - r[1], 0};
  switch (largest) {
    case 0:
      q = {twice * twice, r[7] - r[5], r[2] - r[6], r[3] - r[1]};
      break;
    case 1:
      q = {r[7] - r[5], twice * twice, r[1] + r[3], r[2] + r[6]};
      break;
    case 2:
      q = {r[2] - r[6], r[1] + r[3], twice * twice, r[5] + r[7]};
      break;
    default:
      q = {r[3] - r[1], r[2] + r[6], r[5] + r[7], twice * twice};
  }
  for (double& v : q) v /= 2 * twice;
  return q;
}

void write_colmap(const fs::path& folder, const Scene& scene, std::span<const ViewId> used,
                  std::span<const fs::path> places) {
  std::string cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  std::string images = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  std::vector<Camera> known;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const View& view = scene.views[index(used[i])];
    auto camera = std::find(known.begin(), known.end(), view.camera);
    if (camera == known.end()) {
      std::string lost;
      const std::optional<ColmapLens> lens = colmap_lens(view.camera, lost);
      known.push_back(view.camera);
      camera = known.end() - 1;
      cameras += std::to_string(known.size()) + " " + lens.value().model + " " + std::to_string(view.camera.width) +
                 " " + std::to_string(view.camera.height) + " " + lens.value().terms + "\n";
    }
    const std::array<double, 4> q = quaternion(view.pose.rotation);
    const WorldPoint t = translation(view.pose);
    images += std::to_string(i + 1) + " " + joined({q[0], q[1], q[2], q[3], t.x, t.y, t.z}) + " " +
              std::to_string(camera - known.begin() + 1) + " " +
              places[i].lexically_relative("images").generic_string() + "\n\n";
  }
  write_text(folder / "sparse" / "cameras.txt", cameras);
  write_text(folder / "sparse" / "images.txt", images);
  write_text(folder / "sparse" / "points3D.txt", "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]\n");
}

// --- mvs-texturing

void write_cams(const fs::path& folder, const Scene& scene, std::span<const ViewId> used,
                std::span<const fs::path> places) {
  for (std::size_t i = 0; i < used.size(); ++i) {
    const View& view = scene.views[index(used[i])];
    const Camera& c = view.camera;
    const auto& r = view.pose.rotation;
    const WorldPoint t = translation(view.pose);
    const double aspect = c.fy / c.fx;
    const bool portrait = c.width * aspect < c.height;
    const double f = portrait ? c.fx * aspect / c.height : c.fx / c.width;
    const Distortion& d = c.distortion;
    write_text(folder / fs::path(places[i]).replace_extension(".cam"),
               joined({t.x, t.y, t.z, r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]}) + "\n" +
                   joined({f, d.k1, d.k2, aspect, c.cx / c.width, c.cy / c.height}) + "\n");
  }
}

// --- OpenMVS

class Archive {
 public:
  template <class T>
  void add(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void add_text(const std::string& text) {
    add<std::uint64_t>(text.size());
    bytes_ += text;
  }
  void add_point(const WorldPoint& p) {
    for (const double v : {p.x, p.y, p.z}) add(v);
  }
  void add_matrix(const std::array<double, 9>& m) {
    for (const double v : m) add(v);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_ = "MVSI";
};

/// Version 4 of the interface: what every OpenMVS since 2.0 reads. One platform per camera.
void write_mvs(const fs::path& folder, const Scene& scene, std::span<const ViewId> used,
               std::span<const fs::path> places) {
  constexpr std::array<double, 9> kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<Camera> known;
  std::vector<std::vector<ViewId>> views;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> platform_pose(used.size());
  for (std::size_t i = 0; i < used.size(); ++i) {
    const Camera& camera = scene.views[index(used[i])].camera;
    const auto at = static_cast<std::size_t>(std::find(known.begin(), known.end(), camera) - known.begin());
    if (at == known.size()) {
      known.push_back(camera);
      views.emplace_back();
    }
    platform_pose[i] = {static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(views[at].size())};
    views[at].push_back(used[i]);
  }

  Archive archive;
  archive.add<std::uint32_t>(4);
  archive.add<std::uint32_t>(0);
  archive.add<std::uint64_t>(known.size());
  for (std::size_t p = 0; p < known.size(); ++p) {
    const Camera& c = known[p];
    archive.add_text("platform" + std::to_string(p));
    archive.add<std::uint64_t>(1);
    archive.add_text("camera");
    archive.add_text("");  // band
    archive.add(static_cast<std::uint32_t>(c.width));
    archive.add(static_cast<std::uint32_t>(c.height));
    archive.add_matrix({c.fx, 0, c.cx - 0.5, 0, c.fy, c.cy - 0.5, 0, 0, 1});
    archive.add_matrix(kIdentity);
    archive.add_point({});
    archive.add<std::uint64_t>(views[p].size());
    for (const ViewId id : views[p]) {
      archive.add_matrix(scene.views[index(id)].pose.rotation);
      archive.add_point(scene.views[index(id)].pose.centre);
    }
  }
  archive.add<std::uint64_t>(used.size());
  for (std::size_t i = 0; i < used.size(); ++i) {
    archive.add_text(places[i].generic_string());
    archive.add(platform_pose[i].first);
    archive.add<std::uint32_t>(0);
    archive.add(platform_pose[i].second);
    archive.add(static_cast<std::uint32_t>(i));
  }
  // Vertices, their normals and colours; lines, their normals and colours: none.
  for (int list = 0; list < 6; ++list) archive.add<std::uint64_t>(0);
  for (const double v : {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}) archive.add(v);
  write_text(folder / "scene.mvs", archive.bytes());
}

}  // namespace

std::optional<std::string> lost_term(SceneTarget target, const Camera& camera) {
  if (target == SceneTarget::mvs) return lost_in_pinhole(camera.distortion);
  if (target == SceneTarget::cam) return lost_in_cam(camera);
  std::string lost;
  return colmap_lens(camera, lost) ? std::nullopt : std::optional(lost);
}

std::vector<fs::path> photo_places(SceneTarget target, const Scene& scene, std::span<const ViewId> used) {
  std::vector<fs::path> places;
  std::set<fs::path> taken;
  for (const ViewId id : used) {
    std::string name = fs::path(scene.views[index(id)].name).lexically_normal().generic_string();
    if (target == SceneTarget::cam) std::replace(name.begin(), name.end(), '/', '_');
    places.push_back(target == SceneTarget::cam ? fs::path(name) : fs::path("images") / name);
    const fs::path key = target == SceneTarget::cam ? fs::path(name).replace_extension(".cam") : places.back();
    if (!taken.insert(key).second)
      throw OutputError(key, std::string("two photos would need this name") +
                                 (target == SceneTarget::cam ? " in a folder without sub-folders" : ""));
  }
  return places;
}

std::optional<fs::path> mask_place(SceneTarget target, const fs::path& photo_place) {
  if (target == SceneTarget::cam) return std::nullopt;
  if (target == SceneTarget::mvs) return fs::path(photo_place).replace_extension(".mask.png");
  return fs::path("masks") / (photo_place.lexically_relative("images").string() + ".png");
}

void write_scene(SceneTarget target, const Scene& scene, std::span<const ViewId> used, std::span<const fs::path> places,
                 const fs::path& folder) {
  for (const ViewId id : used)
    if (const auto lost = lost_term(target, scene.views[index(id)].camera))
      throw OutputError(folder,
                        "the format cannot state " + *lost + " of the camera of " + scene.views[index(id)].name);
  if (target == SceneTarget::colmap) write_colmap(folder, scene, used, places);
  if (target == SceneTarget::cam) write_cams(folder, scene, used, places);
  if (target == SceneTarget::mvs) write_mvs(folder, scene, used, places);
}

}  // namespace gpvc::io
