// OpenSfM's reconstruction.json, which OpenDroneMap uses as well: "Dataset Structure" and "Geometric Models" of
// OpenSfM's documentation, opensfm.org/docs; the georeferencing of OpenDroneMap from its run_opensfm stage.
//
// Pixels   normalized: the middle of the photo is (0, 0), its longer side is 1, x right, y down. OpenSfM's pixel
//          coordinates put the first centre at (0, 0) and the middle at ((w - 1) / 2, (h - 1) / 2), so in ours the
//          middle is (w / 2, h / 2): pixel = max(w, h) * normalized + size / 2.
// Camera   x right, y down, z forward: ours.
// Pose     rotation (angle-axis) and translation take world to camera: the centre is -R^T t.
// Lens     perspective, simple_radial, radial and brown as OpenCV's five terms; fisheye and fisheye_opencv as
//          OpenCV's fisheye. fisheye62 and fisheye624 add tangential and prism terms, which act on what the
//          projection makes (camera_distortions_functions.h, Disto624), not on what the radial terms make of it as
//          in Project Aria's model of that name: LensModel::equidistant. spherical (equirectangular) has longitude and
//          latitude over 2 pi for x and y. Terms that a file does not state are 0 and
//          the projection is perspective, as in its io.py.
// World    east, north, up about reference_lla where positions were known. OpenDroneMap replaces it by UTM less an
//          offset, which stands in odm_georeferencing/coords.txt or a file like it, and keeps the former as
//          reconstruction.topocentric.json. It undistorts afterwards: undistorted/reconstruction.json is in the same
//          coordinates.
#include "io/scenes/opensfm_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/lens_terms.h"
#include "io/number_text.h"
#include "io/scenes/panorama_views.h"

namespace gpvc::io {

namespace {

/// A camera's projection_type: its lens, and the terms that the file states. Ours of the prism count across, theirs
/// along: x takes s0 r2 + s1 r2^2, y the other two.
struct Projection {
  std::string_view type;
  LensModel lens;
  bool one_focal;  ///< 'focal' and no principal point, instead of 'focal_x', 'focal_y', 'c_x', 'c_y'
  std::vector<LensTerm> terms;
};

namespace projections {

constexpr LensTerm k1{"k1", &Distortion::k1}, k2{"k2", &Distortion::k2}, k3{"k3", &Distortion::k3},
    k4{"k4", &Distortion::k4}, k5{"k5", &Distortion::k5}, k6{"k6", &Distortion::k6}, p1{"p1", &Distortion::p1},
    p2{"p2", &Distortion::p2}, s0{"s0", &Distortion::s1}, s1{"s1", &Distortion::s3}, s2{"s2", &Distortion::s2},
    s3{"s3", &Distortion::s4};

const std::vector<Projection> kAll{
    {"perspective", LensModel::brown, true, {k1, k2}},
    {"simple_radial", LensModel::brown, false, {k1}},
    {"radial", LensModel::brown, false, {k1, k2}},
    {"brown", LensModel::brown, false, {k1, k2, k3, p1, p2}},
    {"fisheye", LensModel::equidistant, true, {k1, k2}},
    {"fisheye_opencv", LensModel::equidistant, false, {k1, k2, k3, k4}},
    {"fisheye62", LensModel::equidistant, false, {k1, k2, k3, k4, k5, k6, p1, p2}},
    {"fisheye624", LensModel::equidistant, false, {k1, k2, k3, k4, k5, k6, p1, p2, s0, s1, s2, s3}}};

}  // namespace projections

}  // namespace

OpensfmCamera read_opensfm_camera(const JsonFile& json, const std::string& id, const Json& in) {
  const std::string place = "camera " + quote(id);
  if (!in.is_object()) json.fail(place, "expected an object");
  OpensfmCamera result;
  result.lens = in.contains("projection_type") ? json.text(place, in, "projection_type") : "perspective";
  if (result.lens == "spherical" || result.lens == "equirectangular") {
    const int width = json.side(place, in, "width"), height = json.side(place, in, "height");
    result.camera = panorama_camera(json.path(), place, width, height, width / (2 * std::numbers::pi));
    return result;
  }
  const auto projection = std::find_if(projections::kAll.begin(), projections::kAll.end(),
                                       [&](const Projection& p) { return p.type == result.lens; });
  if (projection == projections::kAll.end()) {
    result.refusal = InputError(json.path(), place,
                                "projection type " + quote(result.lens) +
                                    " is not supported; supported are perspective, simple_radial, radial, brown, "
                                    "fisheye, fisheye_opencv, fisheye62, fisheye624 and spherical");
    return result;
  }
  Camera& camera = result.camera;
  camera.width = json.side(place, in, "width");
  camera.height = json.side(place, in, "height");
  const double longer = std::max(camera.width, camera.height);
  const bool one = projection->one_focal;
  camera.fx = longer * json.number(place, in, one ? "focal" : "focal_x");
  camera.fy = longer * json.number(place, in, one ? "focal" : "focal_y");
  camera.cx = camera.width / 2.0 + longer * (one ? 0 : json.optional_number(place, in, "c_x"));
  camera.cy = camera.height / 2.0 + longer * (one ? 0 : json.optional_number(place, in, "c_y"));
  camera.distortion.model = projection->lens;
  for (const auto& [name, term] : projection->terms) camera.distortion.*term = json.optional_number(place, in, name);
  finish_camera(json.path(), place, camera);
  return result;
}

void read_georeferencing(const fs::path& project, SceneFile& scene) {
  const fs::path folder = project / "odm_georeferencing", proj = folder / "proj.txt";
  scene.srs.clear();
  scene.offset = {};
  // The same lines in each. Blocks of a divided run, and results whose point cloud was not kept, have one of the others.
  const fs::path files[] = {folder / "coords.txt", folder / "odm_georeferencing_model_geo.txt",
                            project / "odm_georeferencing_25d" / "odm_georeferencing_model_geo.txt"};
  const auto found = std::ranges::find_if(files, [](const fs::path& file) { return is_file(file); });
  if (found == std::end(files)) {
    scene.warnings.push_back("the positions are in a projected system less an offset, which is not known: " +
                             files[0].string() + " is missing");
    return;
  }
  const fs::path& coords = *found;
  std::optional<FileBytes> definition;
  if (is_file(proj)) definition.emplace(proj);
  const FileBytes bytes(coords);
  parse_georeferencing(coords, bytes.view(), definition ? definition->view() : std::string_view(), scene);
}

namespace {

/// OpenDroneMap's name of a system, "WGS84 UTM 32N", as one that PROJ knows; other text as it is.
std::string utm_system(const std::string& name) {
  std::string_view rest = name;
  if (next_word(rest) != "WGS84" || next_word(rest) != "UTM") return name;
  const std::string_view zone = next_word(rest);
  if (zone.empty() || (zone.back() != 'N' && zone.back() != 'S')) return name;
  const auto number = integer_from(zone.substr(0, zone.size() - 1));
  if (!number || *number < 1 || *number > 60) return name;
  return "EPSG:" + std::to_string((zone.back() == 'N' ? 32600 : 32700) + *number);
}

}  // namespace

void parse_georeferencing(const fs::path& coords, std::string_view text, std::string_view proj_text, SceneFile& scene) {
  scene.srs = utm_system(std::string(next_line(text)));
  const auto x = number_from(next_word(text)), y = number_from(next_word(text));
  if (!x || !y || !std::isfinite(*x) || !std::isfinite(*y))
    throw InputError(coords, "line 2", "expected easting and northing of the offset");
  scene.offset = {*x, *y, 0};
  if (const std::string_view first = next_line(proj_text); !first.empty()) scene.srs = first;
}

namespace {

class OpensfmReader {
 public:
  OpensfmReader(const fs::path& file, std::string_view text)
      : json_(file, text, [](int depth, const std::string& key) { return depth == 2 && key == "points"; }) {
    scene_.listing = file;
  }

  SceneFile read() {
    const Json& root = json_.root();
    if (!root.is_array() || root.empty()) json_.fail("", "expected a list of reconstructions");
    std::size_t best = 0, most = 0;
    for (std::size_t i = 0; i < root.size(); ++i) {
      const Json& reconstruction = root[i];
      if (!reconstruction.is_object() || !reconstruction.contains("shots") || !reconstruction["shots"].is_object() ||
          !reconstruction.contains("cameras") || !reconstruction["cameras"].is_object())
        json_.fail("reconstruction " + std::to_string(i), "expected the objects 'cameras' and 'shots'");
      if (reconstruction["shots"].size() > most) {
        best = i;
        most = reconstruction["shots"].size();
      }
    }
    if (root.size() > 1)
      scene_.warnings.push_back("the file holds " + std::to_string(root.size()) + " reconstructions; the largest, of " +
                                std::to_string(most) + " shots, is read, the others cannot be brought into its frame");
    const Json& reconstruction = root[best];
    for (const auto& [name, shot] : reconstruction["shots"].items()) read_shot(name, shot, reconstruction["cameras"]);
    omitted_.report(scene_);
    scene_.warn(unposed_, "shots without a pose are left out");
    if (reconstruction.contains("reference_lla")) set_reference(scene_, json_.path(), reconstruction["reference_lla"]);
    return std::move(scene_);
  }

  /// {latitude, longitude, altitude}, as embedded or as reference_lla.json. Zeros stand for none.
  static void set_reference(SceneFile& scene, const fs::path& file, const Json& lla) {
    std::array<double, 3> values{};
    constexpr const char* kNames[] = {"latitude", "longitude", "altitude"};
    for (std::size_t i = 0; i < 3; ++i) {
      if (!lla.is_object() || !lla.contains(kNames[i]) || !lla[kNames[i]].is_number())
        throw InputError(file, "reference_lla", "expected the numbers latitude, longitude and altitude");
      values[i] = lla[kNames[i]].get<double>();
    }
    if (values[0] == 0 && values[1] == 0) return;
    scene.srs = "ENU:" + shortest_text(values[0]) + "," + shortest_text(values[1]);
    scene.offset = {0, 0, values[2]};
  }

 private:
  WorldPoint triple(const std::string& place, const Json& object, const char* key) const {
    const std::vector<double> values = json_.numbers(place, object, key, 3);
    return {values[0], values[1], values[2]};
  }

  void read_shot(const std::string& name, const Json& shot, const Json& cameras) {
    const std::string place = "shot " + quote(name);
    if (!shot.is_object()) json_.fail(place, "expected an object");
    if (!shot.contains("rotation") || !shot.contains("translation")) {
      ++unposed_;
      return;
    }
    if (!shot.contains("camera") || !shot["camera"].is_string()) json_.fail(place, "expected the name of a 'camera'");
    const std::string id = shot["camera"].get<std::string>();
    const auto found = cameras.find(id);
    if (found == cameras.end()) json_.fail(place, "its camera " + quote(id) + " is not in the file");
    const auto [camera, fresh] = cameras_.try_emplace(id);
    if (fresh) camera->second = read_opensfm_camera(json_, id, *found);
    if (camera->second.refusal) {
      omitted_.add(camera->second.lens, *camera->second.refusal);
      return;
    }

    View view;
    view.name = stated_photo_name(json_.path(), place, with_slashes(name));
    view.camera = camera->second.camera;
    const WorldPoint t = triple(place, shot, "translation");
    const auto rotation = rotation_from_angle_axis(triple(place, shot, "rotation"));
    if (!rotation) json_.fail(place, "the rotation is not finite");
    view.pose = finish_pose_from_translation(json_.path(), place, *rotation, t);
    scene_.views.push_back(std::move(view));
  }

  JsonFile json_;
  SceneFile scene_;
  std::map<std::string, OpensfmCamera> cameras_;
  OmittedLenses omitted_;
  std::size_t unposed_ = 0;
};

std::optional<fs::path> find_reconstruction(const fs::path& source) {
  if (is_file(source)) {
    if (lower_case(source.extension().string()) != ".json") return std::nullopt;
    const std::string head = first_bytes(source, 256);
    std::string_view text = without_byte_order_mark(head);
    return next_word(text).starts_with('[') ? std::optional(source) : std::nullopt;
  }
  for (const char* below : {"reconstruction.json", "opensfm/reconstruction.json"})
    if (is_file(source / below)) return source / below;
  return std::nullopt;
}

SceneFile parse_reconstruction(const fs::path& file, std::string_view text) { return OpensfmReader(file, text).read(); }

SceneFile read_dataset(const fs::path& found) {
  SceneFile scene = parse_reconstruction(found, FileBytes(found).view());
  const fs::path folder = folder_of(found);
  // The data set's folder, of which the undistorted one is a part.
  const bool undistorted = fs::absolute(found).lexically_normal().parent_path().filename() == "undistorted";
  const fs::path project = undistorted ? folder / ".." : folder;
  const fs::path reference = project / "reference_lla.json";
  if (scene.srs.empty() && is_file(reference))
    OpensfmReader::set_reference(scene, reference, JsonFile(reference, FileBytes(reference).view()).root());
  const std::string name = found.filename().string();
  const bool projected = name.ends_with(".geocoords.json") ||
                         (name == "reconstruction.json" && is_file(project / "reconstruction.topocentric.json"));
  if (projected) read_georeferencing(project / "..", scene);
  scene.image_folders = {folder / "images"};
  // The other photos are not those of undistorted cameras.
  if (!undistorted) scene.image_folders.insert(scene.image_folders.end(), {folder / ".." / "images", folder});
  return scene;
}

}  // namespace

extern const SceneFormat kOpensfm{
    "OpenSfM",
    "an OpenSfM or OpenDroneMap reconstruction.json (or a folder with it, or with opensfm/ in it)",
    find_reconstruction,
    parse_reconstruction,
    {},
    read_dataset};

}  // namespace gpvc::io
