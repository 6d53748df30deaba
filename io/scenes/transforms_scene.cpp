// transforms.json of nerfstudio, instant-ngp and the programs that feed them, and NeRF's transforms_train.json:
// "Data conventions" of docs.nerf.studio, colmap_utils.py and nerfstudio_dataparser.py of
// github.com/nerfstudio-project/nerfstudio, nerf_loader.cu and colmap2nerf.py of github.com/NVlabs/instant-ngp.
//
// Pixels   cx and cy are COLMAP's, as are the rays of both programs, through x + 0.5: ours. Without cx and cy the
//          principal point is the photo's middle.
// Camera   x right, y up, z back (OpenGL): y and z are turned. transform_matrix takes camera to world.
// Shutter  where instant-ngp's files have transform_matrix_start and _end, the camera moved between them, evenly and
//          about one axis. rolling_shutter, A, B, C and D, says when: the place (u, v) of the photo, both from 0 to 1, was
//          taken at A + B u + C v of the way, and up to D later, so D / 2 in the mean. Without it, at the start.
// Lens     k1 to k4, p1 and p2 as Distortion has them; camera_model OPENCV_FISHEYE, or is_fisheye, makes it OpenCV's
//          fisheye. A list distortion_params, k1 to k4, p1, p2, goes before them (nerfstudio_dataparser.py). nerfstudio's EQUIRECTANGULAR (cameras.py) has longitude pi (u - cx) / fl_x and latitude
//          pi (cy - v) / fl_y, with fl_x half the width; instant-ngp's latlong has 2 pi (u / w - 1 / 2) and
//          pi (1 / 2 - v / h). Members of a frame go before those of the file.
// World    any. nerfstudio turns what COLMAP made and says so: applied_transform, then applied_scale, took the original
//          world to the one of the poses. Its meshes are in either (ns-export's --save-world-frame).
#include <algorithm>
#include <array>
#include <cmath>
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

/// A camera of which just the field of view is known is in units of the photo's width, with cx and cy 0.
void scale_by_photo_width(Camera& camera, int width, int height) {
  if (camera.cx != 0 || camera.cy != 0) return;
  camera.fx *= width;
  camera.fy *= width;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
}

double focal_length(double side, double angle) { return side / 2 / std::tan(angle / 2); }

class TransformsReader {
 public:
  TransformsReader(const fs::path& file, std::string_view text) : json_(file, text) {
    scene_.listing = file;
    scene_.size_camera = scale_by_photo_width;
  }

  SceneFile read() {
    if (!json_.root().is_object()) json_.fail("", "expected an object with a list 'frames'");
    const Json& frames = json_.objects("", json_.root(), "frames");
    for (std::size_t i = 0; i < frames.size(); ++i) read_frame("frame " + std::to_string(i), frames[i]);
    omitted_.report(scene_, "frames");
    scene_.warn(untimed_,
                "cameras moved while their photos were taken (transform_matrix_start and _end), and no rolling_shutter "
                "says when they were where: they are taken at the start, as instant-ngp does");
    read_applied_transform();
    return std::move(scene_);
  }

  /// instant-ngp deletes blurred photos and then takes the frames whose photos are still there, if the first of them
  /// has a sharpness.
  bool may_lack_photos() const { return json_.root()["frames"].at(0).contains("sharpness"); }

 private:
  static constexpr const char *kStart = "transform_matrix_start", *kEnd = "transform_matrix_end",
                              *kShutter = "rolling_shutter", *kLatlong = "latlong",
                              *kEquirectangular = "EQUIRECTANGULAR";

  /// The object that states a member for a frame: the frame or the file.
  const Json& owner(const Json& frame, const char* key) const { return frame.contains(key) ? frame : json_.root(); }
  bool has(const Json& frame, const char* key) const { return owner(frame, key).contains(key); }

  void read_frame(const std::string& number, const Json& frame) {
    View view;
    view.photo = with_slashes(json_.text(number, frame, "file_path"));
    view.name = stated_photo_name(json_.path(), number, view.photo.lexically_normal().string());
    const std::string place = "frame " + quote(view.name);
    if (frame.contains("mask_path")) view.mask = with_slashes(json_.text(place, frame, "mask_path"));
    const std::optional<LensModel> model = lens_of(place, frame);
    if (!model) return;
    view.camera = is_spherical(*model) ? panorama_of(place, frame) : camera_of(place, frame, *model);

    const bool has_start = frame.contains(kStart) && frame.contains(kEnd);
    const Placed start = placed(place, frame, has_start ? kStart : "transform_matrix");
    const Placed at =
        has_start && !is_spherical(*model) ? moving(place, frame, start, view.camera.distortion.motion) : start;
    view.pose = finish_pose(json_.path(), place, transposed(at.world_from_camera), at.centre);
    scene_.views.push_back(std::move(view));
  }

  /// Three rows of four numbers, and perhaps a fourth.
  std::vector<double> matrix_of(const std::string& place, const Json& frame, const char* key) const {
    const auto matrix = frame.find(key);
    const std::size_t rows = matrix != frame.end() && matrix->size() == 3 ? 3 : 4;
    return json_.numbers(place, frame, key, 4, rows);
  }

  struct Placed {
    Matrix3 world_from_camera;
    WorldPoint centre;
  };

  Placed placed(const std::string& place, const Json& frame, const char* key) const {
    const std::vector<double> m = matrix_of(place, frame, key);
    const auto rotation = rotation_near({m[0], -m[1], -m[2], m[4], -m[5], -m[6], m[8], -m[9], -m[10]});
    if (!rotation) json_.fail(place, "its transform_matrix has no rotation in it");
    return {*rotation, {m[3], m[7], m[11]}};
  }

  /// Where the camera was when the middle of the photo was taken, and how it moved.
  Placed moving(const std::string& place, const Json& frame, const Placed& start, Motion& motion) {
    const Placed end = placed(place, frame, kEnd);
    const Json& stated = owner(frame, kShutter);
    std::vector<double> when(4);
    if (has(frame, kShutter)) when = json_.numbers(place, stated, kShutter, stated[kShutter].size() == 3 ? 3 : 4);
    when.resize(4);
    const auto [a, b, c, d] = std::array{when[0], when[1], when[2], when[3]};
    const std::array<double, 3> turn =
        angle_axis_from_rotation(product(transposed(start.world_from_camera), end.world_from_camera));
    const WorldPoint step{end.centre.x - start.centre.x, end.centre.y - start.centre.y, end.centre.z - start.centre.z};
    const bool moves = turn != std::array<double, 3>{} || step != WorldPoint{};
    untimed_ += moves && !has(frame, kShutter) ? 1 : 0;
    const double middle = a + (b + c + d) / 2;
    const auto turned = rotation_from_angle_axis({middle * turn[0], middle * turn[1], middle * turn[2]});
    if (!turned) json_.fail(place, "its rolling_shutter and its transform_matrix_end make no rotation");
    const Placed at{
        product(start.world_from_camera, *turned),
        {start.centre.x + middle * step.x, start.centre.y + middle * step.y, start.centre.z + middle * step.z}};
    if (moves) {
      const WorldPoint s = product(transposed(at.world_from_camera), step);
      motion = {.across = b, .down = c, .turn = {-turn[0], -turn[1], -turn[2]}, .step = {s.x, s.y, s.z}};
    }
    return at;
  }

  /// nullopt where the frame is left out.
  std::optional<LensModel> lens_of(const std::string& place, const Json& frame) {
    constexpr std::string_view kPerspective[] = {"", "SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV"};
    const bool named = has(frame, "camera_model");
    std::string model = named ? json_.text(place, owner(frame, "camera_model"), "camera_model") : "";
    for (const char* other : {"ftheta_p0", kLatlong, "equirectangular", "orthographic"})
      if (has(frame, other)) model = other;
    if (model == kEquirectangular || model == kLatlong) return LensModel::spherical;
    const Json& fisheye = owner(frame, "is_fisheye");
    if (model == "OPENCV_FISHEYE" || fisheye.value("is_fisheye", Json()) == true) return LensModel::equidistant;
    if (std::ranges::find(kPerspective, model) != std::end(kPerspective)) return LensModel::perspective;
    omitted_.add(model, InputError(json_.path(), place,
                                   "the camera model " + quote(model) +
                                       " is not supported; supported are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, "
                                       "RADIAL, OPENCV, OPENCV_FISHEYE and EQUIRECTANGULAR"));
    return std::nullopt;
  }

  double number(const std::string& place, const Json& frame, const char* key) const {
    return json_.number(place, owner(frame, key), key);
  }

  Camera panorama_of(const std::string& place, const Json& frame) const {
    const int width = json_.side(place, owner(frame, "w"), "w"), height = json_.side(place, owner(frame, "h"), "h");
    if (has(frame, kLatlong)) return panorama_camera(json_.path(), place, width, height, height / std::numbers::pi);
    const double across = has(frame, "fl_x") ? number(place, frame, "fl_x") : width / 2.0,
                 down = has(frame, "fl_y") ? number(place, frame, "fl_y") : across;
    if (across != width / 2.0)
      json_.fail(place, "expected half the photo's width, " + general_text(width / 2.0) + ", as 'fl_x' of " +
                            kEquirectangular + ", found " + general_text(across));
    const PhotoPoint off{has(frame, "cx") ? number(place, frame, "cx") - width / 2.0 : 0,
                         has(frame, "cy") ? number(place, frame, "cy") - height / 2.0 : 0};
    return panorama_camera(json_.path(), place, width, height, down / std::numbers::pi, off);
  }

  Camera camera_of(const std::string& place, const Json& frame, LensModel model) const {
    const auto number = [&](const char* key) { return this->number(place, frame, key); };
    Camera camera;
    constexpr const char* kPixels[] = {"w", "h", "fl_x", "cx", "cy"};
    const bool sized = std::ranges::any_of(kPixels, [&](const char* key) { return has(frame, key); });
    if (sized) {
      camera.width = json_.side(place, owner(frame, "w"), "w");
      camera.height = json_.side(place, owner(frame, "h"), "h");
    }
    if (has(frame, "fl_x")) {
      camera.fx = number("fl_x");
      camera.fy = has(frame, "fl_y") ? number("fl_y") : camera.fx;
    } else if (has(frame, "camera_angle_x")) {
      camera.fx = focal_length(sized ? camera.width : 1, number("camera_angle_x"));
      camera.fy =
          sized && has(frame, "camera_angle_y") ? focal_length(camera.height, number("camera_angle_y")) : camera.fx;
    } else {
      json_.fail(place, "has neither 'fl_x' nor 'camera_angle_x'");
    }
    camera.cx = has(frame, "cx") ? number("cx") : camera.width / 2.0;
    camera.cy = has(frame, "cy") ? number("cy") : camera.height / 2.0;
    camera.distortion.model = model;
    constexpr LensTerm kTerms[] = {{"k1", &Distortion::k1}, {"k2", &Distortion::k2}, {"k3", &Distortion::k3},
                                   {"k4", &Distortion::k4}, {"p1", &Distortion::p1}, {"p2", &Distortion::p2}};
    constexpr const char* kList = "distortion_params";
    std::vector<double> listed;
    if (has(frame, kList)) listed = json_.numbers(place, owner(frame, kList), kList, std::size(kTerms));
    for (std::size_t i = 0; i < std::size(kTerms); ++i) {
      const auto& [name, term] = kTerms[i];
      camera.distortion.*term = listed.empty() ? json_.optional_number(place, owner(frame, name), name) : listed[i];
    }
    finish_camera(json_.path(), place, camera);
    return camera;
  }

  /// x_pose = scale (A x_original + t): the original frame is (1 / scale) A^T (x_pose - scale t).
  void read_applied_transform() {
    constexpr const char* kTransform = "applied_transform";
    const Json& root = json_.root();
    const double scale = json_.optional_number("", root, "applied_scale", 1);
    if (!(scale > 0 && std::isfinite(1 / scale))) json_.fail("", "expected a positive number as 'applied_scale'");
    std::vector<double> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    // What nerfstudio did to COLMAP's world before its files stated it (nerfstudio_dataparser.py).
    if (is_folder(folder_of(json_.path()) / "colmap" / "sparse" / "0")) m = {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0};
    if (root.contains(kTransform)) m = json_.numbers("", root, kTransform, 4, root[kTransform].size() == 4 ? 4 : 3);
    const auto rotation = rotation_near({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
    if (!rotation) json_.fail("", "'applied_transform' has no rotation in it");
    const SceneFrame original{"the coordinates before applied_transform",
                              transposed(*rotation),
                              {scale * m[3], scale * m[7], scale * m[11]},
                              1 / scale};
    const SceneFrame same;
    if (original.rotation != same.rotation || original.origin != same.origin || scale != 1)
      scene_.other_frames = {original};
  }

  JsonFile json_;
  SceneFile scene_;
  OmittedLenses omitted_;
  std::size_t untimed_ = 0;
};

std::optional<fs::path> find_transforms(const fs::path& source) {
  const auto fits = [](const fs::path& file) { return json_root_keys(file).contains("frames"); };
  if (is_file(source)) return fits(source) ? std::optional(source) : std::nullopt;
  for (const char* name : {"transforms.json", "transforms_train.json"})
    if (fits(source / name)) return source / name;
  return std::nullopt;
}

SceneFile parse_transforms(const fs::path& file, std::string_view text) { return TransformsReader(file, text).read(); }

SceneFile read_transforms(const fs::path& file) {
  TransformsReader reader(file, FileBytes(file).view());
  SceneFile scene = reader.read();
  const fs::path folder = folder_of(file);
  scene.image_folders = {folder / "images", folder};
  // NeRF's own scenes leave out the photos' extension.
  for (View& view : scene.views)
    for (const char* extension : {".png", ".jpg", ".jpeg", ".JPG", ".exr"}) {
      if (is_file(folder / view.photo) || !is_file(folder / (view.photo.string() + extension))) continue;
      view.photo += extension;
      view.name += extension;
    }
  const auto is_there = [&](const View& view) { return is_file(folder / view.photo); };
  if (std::ranges::any_of(scene.views, is_there) && reader.may_lack_photos())
    scene.warn(std::erase_if(scene.views, [&](const View& view) { return !is_there(view); }),
               "frames are left out: their photos are not there, as instant-ngp's tools delete blurred ones");
  return scene;
}

}  // namespace

extern const SceneFormat kTransforms{"transforms.json",
                                     "a transforms.json of nerfstudio or instant-ngp (or a folder with it)",
                                     find_transforms,
                                     parse_transforms,
                                     {},
                                     read_transforms};

}  // namespace gpvc::io
