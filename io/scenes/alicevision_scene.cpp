// AliceVision's and Meshroom's cameras.sfm, or sfm.json: jsonIO.cpp, IntrinsicScaleOffset.cpp and Distortion*.cpp of
// github.com/alicevision/AliceVision, versions 1.0.0 to 1.2.11, which differ in how they state a camera.
//
// Pixels   the centre of the upper left pixel is (0, 0), x right, y down, as its undistortion samples photos: the principal
//          point moves by half a pixel. It is stated from the photo's middle, (w / 2, h / 2), since 1.2.1.
// Camera   x right, y down, z forward: ours. Focal lengths are in pixels before 1.2.2, then in the sensor's millimetres.
// Pose     the matrix, column by column, takes world to camera; center is the centre.
// Lens     radialk1, radialk3, brown (k1 k2 k3 p1 p2), fisheye (OpenCV's), fisheye1 (one field of view), on a pinhole
//          camera; by other names, as the type of the camera, before 1.2.8.
// Numbers  are in quotes, and empty lists are "".
#include <array>
#include <cmath>
#include <map>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/lens_terms.h"
#include "io/number_text.h"
#include "io/scenes/json_file.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

struct NamedLens {
  const char* name;    ///< distortionType
  const char* before;  ///< the type before 1.2.8
  LensModel model;
  std::vector<double Distortion::*> terms;
};

const std::vector<NamedLens> kNamedLenses{
    {"none", "pinhole", LensModel::brown, {}},
    {"radialk1", "radial1", LensModel::brown, {&Distortion::k1}},
    {"radialk3", "radial3", LensModel::brown, {&Distortion::k1, &Distortion::k2, &Distortion::k3}},
    {"brown",
     "brown",
     LensModel::brown,
     {&Distortion::k1, &Distortion::k2, &Distortion::k3, &Distortion::p1, &Distortion::p2}},
    {"fisheye",
     "fisheye4",
     LensModel::equidistant,
     {&Distortion::k1, &Distortion::k2, &Distortion::k3, &Distortion::k4}},
    {"fisheye1", "fisheye1", LensModel::fov, {&Distortion::omega}}};

using FileVersion = std::array<double, 3>;

class AlicevisionReader {
 public:
  AlicevisionReader(const fs::path& file, std::string_view text)
      : json_(
            file, text, [](int depth, const std::string& key) { return depth == 1 && key == "structure"; },
            JsonNumbers::quoted) {
    scene_.listing = file;
  }

  SceneFile read() {
    const Json& root = json_.root();
    if (!root.is_object()) json_.fail("", "expected an object with 'views', 'intrinsics' and 'poses'");
    const std::vector<double> version = json_.numbers("", root, "version", 3);
    version_ = {version[0], version[1], version[2]};
    for (const Json& pose : list(root, "poses")) poses_[json_.number("poses", pose, "poseId")] = &pose;
    for (const Json& intrinsic : list(root, "intrinsics"))
      intrinsics_[json_.number("intrinsics", intrinsic, "intrinsicId")] = &intrinsic;
    for (const Json& view : list(root, "views")) read_view(view);
    omitted_.report(scene_);
    scene_.warn(unposed_, "images without a pose are left out");
    scene_.warn(of_rigs_, "images are left out: their pose is that of a rig");
    return std::move(scene_);
  }

 private:
  const Json& list(const Json& root, const char* key) const {
    static const Json kNone = Json::array();
    return root.value(key, Json("")) == "" ? kNone : json_.objects("", root, key);
  }

  void read_view(const Json& in) {
    const std::string path = with_slashes(json_.text("views", in, "path"));
    const std::string place = "image " + quote(path);
    // A view of a rig states that its pose is not its own.
    if (const Json own = in.value("isPoseIndependant", Json("true")); own != "true" && own != "1" && own != true) {
      ++of_rigs_;
      return;
    }
    const auto pose = poses_.find(json_.optional_number(place, in, "poseId", -1));
    const auto intrinsic = intrinsics_.find(json_.optional_number(place, in, "intrinsicId", -1));
    if (pose == poses_.end() || intrinsic == intrinsics_.end()) {
      ++unposed_;
      return;
    }
    const std::string of_camera = "intrinsic " + general_text(intrinsic->first);
    const NamedLens* lens = lens_of(of_camera, *intrinsic->second);
    if (lens == nullptr) return;
    const auto [camera, fresh] = cameras_.try_emplace(intrinsic->first);
    if (fresh) camera->second = camera_of(of_camera, *intrinsic->second, *lens);
    View view;
    view.name = stated_photo_name(json_.path(), place, path);
    view.photo = path;
    view.camera = camera->second;
    view.pose = pose_of(place, *pose->second);
    scene_.views.push_back(std::move(view));
  }

  Pose pose_of(const std::string& place, const Json& in) const {
    const Json& transform = json_.object(place, json_.object(place, in, "pose"), "transform");
    const std::vector<double> m = json_.numbers(place, transform, "rotation", 9),
                              c = json_.numbers(place, transform, "center", 3);
    const auto rotation = rotation_near({m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]});
    if (!rotation) json_.fail(place, "its rotation is none");
    return finish_pose(json_.path(), place, *rotation, {c[0], c[1], c[2]});
  }

  /// Null where the images are left out.
  const NamedLens* lens_of(const std::string& place, const Json& in) {
    const bool combined = version_ < FileVersion{1, 2, 8};
    std::string name = lower_case(json_.text(place, in, "type"));
    if (!combined && name == "pinhole") {
      name = lower_case(json_.text(place, in, "distortionType"));
      const std::string undistortion =
          in.contains("undistortionType") ? lower_case(json_.text(place, in, "undistortionType")) : "none";
      if (undistortion != "none") name = undistortion;
    }
    for (const NamedLens& lens : kNamedLenses)
      if (name == (combined ? lens.before : lens.name)) return &lens;
    omitted_.add(name, InputError(json_.path(), place,
                                  "the lens " + quote(name) +
                                      " is not supported; supported are pinhole cameras without distortion, with "
                                      "radialk1, radialk3, brown, fisheye and fisheye1"));
    return nullptr;
  }

  Camera camera_of(const std::string& place, const Json& in, const NamedLens& lens) const {
    Camera camera;
    camera.width = json_.side(place, in, "width");
    camera.height = json_.side(place, in, "height");
    set_focal_length(place, in, camera);
    const std::vector<double> centre = json_.numbers(place, in, "principalPoint", 2);
    const bool from_middle = version_ >= FileVersion{1, 2, 1};
    camera.cx = centre[0] + (from_middle ? camera.width / 2.0 : 0) + 0.5;
    camera.cy = centre[1] + (from_middle ? camera.height / 2.0 : 0) + 0.5;
    // As AliceVision does, a list of another length is taken for none.
    const auto terms = in.find("distortionParams");
    if (terms != in.end() && terms->is_array() && terms->size() == lens.terms.size()) {
      const std::vector<double> values = json_.numbers(place, in, "distortionParams", lens.terms.size());
      camera.distortion.model = lens.model;
      for (std::size_t i = 0; i < values.size(); ++i) camera.distortion.*lens.terms[i] = values[i];
    }
    finish_camera(json_.path(), place, camera);
    return camera;
  }

  void set_focal_length(const std::string& place, const Json& in, Camera& camera) const {
    if (version_ < FileVersion{1, 2, 0}) {
      camera.fx = camera.fy = json_.number(place, in, "pxFocalLength");
      return;
    }
    if (version_ < FileVersion{1, 2, 2}) {
      const std::vector<double> both = json_.numbers(place, in, "pxFocalLength", 2);
      camera.fx = both[0];
      camera.fy = both[1];
      return;
    }
    const double ratio = json_.optional_number(place, in, "pixelRatio", 1);
    const double per_millimetre = 1 / json_.optional_number(place, in, "sensorWidth", 36);
    const double f = json_.number(place, in, "focalLength") * per_millimetre;
    if (version_ < FileVersion{1, 2, 11}) {
      camera.fx = f * camera.width;
      camera.fy = version_ < FileVersion{1, 2, 5} ? camera.fx / ratio : camera.fx * ratio;
    } else {
      camera.fy = f * std::max(camera.width, camera.height);
      camera.fx = camera.fy / ratio;
    }
  }

  JsonFile json_;
  SceneFile scene_;
  FileVersion version_{};
  std::map<double, const Json*> poses_, intrinsics_;
  std::map<double, Camera> cameras_;
  OmittedLenses omitted_;
  std::size_t unposed_ = 0, of_rigs_ = 0;
};

bool is_sfm(const fs::path& file) {
  const std::set<std::string> keys = json_root_keys(file);
  return keys.contains("views") && keys.contains("version");
}

std::optional<fs::path> find_sfm(const fs::path& source) {
  for (const char* name : {"cameras.sfm", "sfm.sfm", "sfm.json"})
    if (is_sfm(source / name)) return source / name;
  if (is_sfm(source)) return source;
  return find_file(source, ".sfm", is_sfm);
}

}  // namespace

extern const SceneFormat kAlicevision{
    "AliceVision",
    "a cameras.sfm or sfm.json of Meshroom (or a folder with it)",
    find_sfm,
    [](const fs::path& file, std::string_view text) { return AlicevisionReader(file, text).read(); },
    {"images", "../images"}};

}  // namespace gpvc::io
