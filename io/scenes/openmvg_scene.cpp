// OpenMVG's sfm_data.json: "SfM_data format" of openmvg.readthedocs.io, and sfm_data_io_cereal.cpp, sfm_view_io.hpp and
// Camera_Pinhole_*.hpp of github.com/openMVG/openMVG, versions 0.2 and 0.3.
//
// Pixels   the centre of the upper left pixel is (0, 0), x right, y down, as its undistortion samples photos (get_d_pixel
//          of whole numbers): the principal point moves by half a pixel.
// Camera   x right, y down, z forward: ours.
// Pose     rotation takes world to camera, center is the centre.
// Lens     told by the list of its terms: disto_k1, disto_k3, disto_t2 (k1 k2 k3 p1 p2), fisheye (OpenCV's k1 to k4), or
//          none. Spherical cameras (Camera_Spherical.hpp) have no focal length: u = w / 2 + f atan(x / z),
//          v = h / 2 + f atan(y / sqrt(x^2 + z^2)), f = max(w, h) / (2 pi).
#include <cmath>
#include <map>
#include <numbers>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/lens_terms.h"
#include "io/number_text.h"
#include "io/scenes/json_file.h"
#include "io/scenes/panorama_views.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

struct TermList {
  const char* key;
  LensModel model;
  std::vector<double Distortion::*> terms;
};

const std::vector<TermList> kTermLists{
    {"disto_k1", LensModel::brown, {&Distortion::k1}},
    {"disto_k3", LensModel::brown, {&Distortion::k1, &Distortion::k2, &Distortion::k3}},
    {"disto_t2",
     LensModel::brown,
     {&Distortion::k1, &Distortion::k2, &Distortion::k3, &Distortion::p1, &Distortion::p2}},
    {"fisheye", LensModel::equidistant, {&Distortion::k1, &Distortion::k2, &Distortion::k3, &Distortion::k4}}};

bool is_landmarks(int depth, const std::string& key) {
  return depth == 1 && (key == "structure" || key == "control_points");
}

class OpenmvgReader {
 public:
  OpenmvgReader(const fs::path& file, std::string_view text) : json_(file, text, is_landmarks) {
    scene_.listing = file;
  }

  SceneFile read() {
    const Json& root = json_.root();
    if (!root.is_object()) json_.fail("", "expected an object with 'views', 'intrinsics' and 'extrinsics'");
    folder_ = root.contains("root_path") ? with_slashes(json_.text("", root, "root_path")) : "";
    read_keyed("extrinsics",
               [this](double key, const std::string& place, const Json& pose) { poses_[key] = pose_of(place, pose); });
    read_keyed("intrinsics", [this](double key, const std::string& place, const Json& value) {
      intrinsics_[key] = data_of(place, value);
    });
    read_keyed("views", [this](double, const std::string& place, const Json& value) {
      read_view(place, *data_of(place, value));
    });
    scene_.warn(unposed_, "images without a pose are left out");
    return std::move(scene_);
  }

 private:
  /// A list of {"key": NUMBER, "value": {...}}.
  template <class Take>
  void read_keyed(const char* name, Take take) {
    for (const Json& entry : json_.objects("", json_.root(), name)) {
      const double key = json_.number(name, entry, "key");
      const std::string place = std::string(name) + ' ' + general_text(key);
      take(key, place, json_.object(place, entry, "value"));
    }
  }

  /// What is within the wrappers of a polymorphic value.
  const Json* data_of(const std::string& place, const Json& value) const {
    return &json_.object(place, json_.object(place, value, "ptr_wrapper"), "data");
  }

  Pose pose_of(const std::string& place, const Json& in) const {
    const std::vector<double> m = json_.numbers(place, in, "rotation", 3, 3), c = json_.numbers(place, in, "center", 3);
    const auto rotation = rotation_near({m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]});
    if (!rotation) json_.fail(place, "its rotation is none");
    return finish_pose(json_.path(), place, *rotation, {c[0], c[1], c[2]});
  }

  void read_view(const std::string& place, const Json& in) {
    const auto pose = poses_.find(json_.number(place, in, "id_pose"));
    const auto intrinsic = intrinsics_.find(json_.number(place, in, "id_intrinsic"));
    if (pose == poses_.end() || intrinsic == intrinsics_.end()) {
      ++unposed_;
      return;
    }
    const fs::path name =
        fs::path(with_slashes(json_.text(place, in, "local_path"))) / with_slashes(json_.text(place, in, "filename"));
    const auto [camera, fresh] = cameras_.try_emplace(intrinsic->first);
    if (fresh) camera->second = camera_of("intrinsics " + general_text(intrinsic->first), *intrinsic->second);
    View view;
    view.name = stated_photo_name(json_.path(), place, name.lexically_normal().string());
    view.photo = folder_ / name;
    view.camera = camera->second;
    view.pose = pose->second;
    scene_.views.push_back(std::move(view));
  }

  /// Some versions wrap the members of the class that all lenses share.
  static const Json& base_of(const Json& in) {
    const auto wrapped = in.find("value0");
    return wrapped != in.end() && wrapped->is_object() ? *wrapped : in;
  }

  Camera camera_of(const std::string& place, const Json& in) const {
    const Json& base = base_of(in);
    Camera camera;
    camera.width = json_.side(place, base, "width");
    camera.height = json_.side(place, base, "height");
    if (!base.contains("focal_length")) {
      if (camera.height > camera.width)
        json_.fail(place, "has no focal length, and is not as wide as a spherical photo");
      return panorama_camera(json_.path(), place, camera.width, camera.height, camera.width / (2 * std::numbers::pi),
                             {0.5, 0.5});
    }
    camera.fx = camera.fy = json_.number(place, base, "focal_length");
    const std::vector<double> centre = json_.numbers(place, base, "principal_point", 2);
    camera.cx = centre[0] + 0.5;
    camera.cy = centre[1] + 0.5;
    for (const TermList& list : kTermLists) {
      if (!in.contains(list.key)) continue;
      camera.distortion.model = list.model;
      const std::vector<double> values = json_.numbers(place, in, list.key, list.terms.size());
      for (std::size_t i = 0; i < values.size(); ++i) camera.distortion.*list.terms[i] = values[i];
    }
    finish_camera(json_.path(), place, camera);
    return camera;
  }

  JsonFile json_;
  SceneFile scene_;
  fs::path folder_;
  std::map<double, Pose> poses_;
  std::map<double, const Json*> intrinsics_;
  std::map<double, Camera> cameras_;
  std::size_t unposed_ = 0;
};

bool is_sfm_data(const fs::path& file) { return json_root_keys(file).contains("sfm_data_version"); }

}  // namespace

extern const SceneFormat kOpenmvg{
    "OpenMVG",
    "an OpenMVG sfm_data.json (or a folder with it)",
    [](const fs::path& source) { return find_file(source, ".json", is_sfm_data); },
    [](const fs::path& file, std::string_view text) { return OpenmvgReader(file, text).read(); },
    {"images", "../images"}};

}  // namespace gpvc::io
