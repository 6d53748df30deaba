// OPF, the Open Photogrammetry Format of PIX4Dmatic, PIX4Dcloud and others: version 1.0 of the specification,
// github.com/Pix4D/opf-spec; opf2colmap and compute_reprojection_error of github.com/Pix4D/pyopf, which agree with it.
//
// The project, .opf, lists items with resources. Of these are read the calibrated cameras, the list of cameras (photos),
// the input cameras (sizes) and the scene reference frame.
//
// Pixels   (0, 0) is the upper left corner of the upper left pixel, x right, y down: ours.
// Camera   x right, y up, z backward: y and z turn round. Rx(omega) Ry(phi) Rz(kappa) takes camera to world.
// Lens     perspective: Brown's with OpenCV's order and signs, x (1 + R1 r2 + R2 r4 + R3 r6) + 2 T1 x y + T2 (r2 + 2 x
//          x); fisheye: a polynomial of the angle, see set_fisheye(). Spherical ones are not read.
// World    the "processing" system: the reference system with equal scales, its first two axes swapped where it is
//          left-handed (north, east), then shifted. East comes first in ours as well (see reference_system.h), so the
//          swap needs nothing; scales other than 1 leave a system that has no name.
// Photos   URI references, relative to the camera list.
#include <algorithm>
#include <array>
#include <charconv>
#include <map>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scenes/json_file.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

constexpr std::array<const char*, 4> kOpfFormats{
    "application/opf-camera-list+json", "application/opf-input-cameras+json", "application/opf-calibrated-cameras+json",
    "application/opf-scene-reference-frame+json"};
enum OpfFormat : std::size_t { kOpfCameraList, kOpfInputCameras, kOpfCalibratedCameras, kOpfReferenceFrame };

/// The path of a URI reference, without its fragment.
std::string path_of_uri(std::string_view uri) {
  uri = uri.substr(0, uri.find('#'));
  if (uri.starts_with("file:")) uri.remove_prefix(5);
  if (uri.starts_with("//")) {
    uri.remove_prefix(2);
    uri.remove_prefix(std::min(uri.find('/'), uri.size()));  // the host
  }
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned char byte = 0;
    const char* const digits = uri.data() + i + 1;
    if (uri[i] == '%' && uri.size() - i > 2 && std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
      path += static_cast<char>(byte);
      i += 2;
    } else {
      path += uri[i];
    }
  }
  path = with_slashes(path);
  const bool drive = path.size() > 2 && path[0] == '/' && path[2] == ':';
  return drive ? path.substr(1) : path;
}

/// The page of a file with several that the URI names; 0, the first, if it names none.
std::string_view page_of_uri(std::string_view uri) {
  constexpr std::string_view kPage = "#page=";
  const std::size_t at = uri.find(kPage);
  return at == std::string_view::npos ? "0" : uri.substr(at + kPage.size());
}

class OpfReader {
 public:
  explicit OpfReader(const fs::path& project) : project_(project) { scene_.listing = project; }

  SceneFile read() {
    find_resources();
    if (resources_[kOpfCalibratedCameras].empty())
      throw InputError(project_, "", "has no calibrated cameras: its photos have no poses yet");
    for (const fs::path& file : resources_[kOpfCameraList]) read_camera_list(file);
    for (const fs::path& file : resources_[kOpfInputCameras]) read_sizes(file);
    if (!resources_[kOpfReferenceFrame].empty()) read_frame(resources_[kOpfReferenceFrame].front());
    read_cameras(resources_[kOpfCalibratedCameras].front());
    for (const std::vector<fs::path>& files : resources_)
      scene_.files.insert(scene_.files.end(), files.begin(), files.end());
    scene_.files.push_back(project_);
    if (const std::size_t all = resources_[kOpfCalibratedCameras].size(); all > 1)
      scene_.warnings.push_back("the project holds " + std::to_string(all) + " calibrations; the first is read");
    return std::move(scene_);
  }

 private:
  void find_resources() {
    const JsonFile json(project_, FileBytes(project_).view());
    if (!json.root().is_object()) json.fail("", "expected an object with 'items'");
    std::size_t number = 0;
    for (const Json& item : json.objects("", json.root(), "items")) {
      const std::string place = "items " + std::to_string(number++);
      for (const Json& resource : json.objects(place, item, "resources")) {
        const std::string format = json.text(place, resource, "format");
        const auto wanted = std::find(kOpfFormats.begin(), kOpfFormats.end(), format);
        if (wanted == kOpfFormats.end()) continue;
        const std::string uri = json.text(place, resource, "uri");
        const fs::path file = (folder_of(project_) / path_of_uri(uri)).lexically_normal();
        if (fs::path(path_of_uri(uri)).is_absolute() || !is_file(file))
          json.fail(place, "there is no file " + quote(uri) + " beside the project");
        resources_[static_cast<std::size_t>(wanted - kOpfFormats.begin())].push_back(file);
      }
    }
  }

  /// Checks that the file is what the project says, of a known version.
  static void check_kind(const JsonFile& json, OpfFormat format) {
    if (!json.root().is_object() || json.text("", json.root(), "format") != kOpfFormats[format])
      json.fail("", std::string("expected an object whose 'format' is ") + kOpfFormats[format]);
    if (const std::string version = json.text("", json.root(), "version"); !version.starts_with("1."))
      json.fail("", "is of version " + quote(version) + ", expected 1");
  }

  /// Numbers of 64 bits, beyond what doubles tell apart.
  static std::uint64_t id_in(const JsonFile& json, const std::string& place, const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number_unsigned())
      json.fail(place, std::string("expected a whole number as '") + key + "'");
    return found->get<std::uint64_t>();
  }

  void read_camera_list(const fs::path& file) {
    const JsonFile json(file, FileBytes(file).view());
    check_kind(json, kOpfCameraList);
    for (const Json& camera : json.objects("", json.root(), "cameras")) {
      const std::uint64_t id = id_in(json, "cameras", camera, "id");
      uris_[id] = json.text("camera " + std::to_string(id), camera, "uri");
    }
    scene_.listing = resources_[kOpfCameraList].front();
  }

  void read_sizes(const fs::path& file) {
    const JsonFile json(file, FileBytes(file).view());
    check_kind(json, kOpfInputCameras);
    for (const Json& sensor : json.objects("", json.root(), "sensors")) {
      const std::uint64_t id = id_in(json, "sensors", sensor, "id");
      const std::string place = "sensor " + std::to_string(id);
      const std::vector<double> size = json.numbers(place, sensor, "image_size_px", 2);
      const auto width = image_side(size[0]), height = image_side(size[1]);
      if (!width || !height) json.fail(place, "expected whole numbers of 1 to 2^24 pixels as 'image_size_px'");
      sizes_[id] = {*width, *height};
    }
  }

  void read_frame(const fs::path& file) {
    const JsonFile json(file, FileBytes(file).view());
    check_kind(json, kOpfReferenceFrame);
    const std::string srs = reference_system(json.text("crs", json.object("", json.root(), "crs"), "definition"));
    const char* const kShift = "base_to_canonical";
    const Json& transform = json.object("", json.root(), kShift);
    const std::vector<double> shift = json.numbers(kShift, transform, "shift", 3);
    if (json.numbers(kShift, transform, "scale", 3) != std::vector<double>{1, 1, 1}) {
      scene_.warnings.push_back(
          "the reference system has axes of different units, which the cameras' coordinates have not: it is not "
          "stated further");
      return;
    }
    scene_.srs = srs;
    scene_.offset = {0 - shift[0], 0 - shift[1], 0 - shift[2]};  // not -0
    if (scene_.offset == WorldPoint{}) return;
    SceneFrame whole;
    whole.name = "the coordinates without the project's shift";
    whole.origin = {shift[0], shift[1], shift[2]};
    whole.srs = srs;
    scene_.other_frames = {whole};
  }

  void read_cameras(const fs::path& file) {
    const JsonFile json(file, FileBytes(file).view());
    check_kind(json, kOpfCalibratedCameras);
    std::map<std::uint64_t, const Json*> internals;
    for (const Json& sensor : json.objects("", json.root(), "sensors")) {
      const std::uint64_t id = id_in(json, "sensors", sensor, "id");
      internals[id] = &json.object("sensor " + std::to_string(id), sensor, "internals");
    }
    std::size_t moving = 0, pages = 0, unlisted = 0;
    OmittedLenses omitted;
    const Json& cameras = json.objects("", json.root(), "cameras");
    for (const Json& in : cameras) {
      const std::uint64_t id = id_in(json, "cameras", in, "id");
      const std::string place = "camera " + std::to_string(id);
      const std::uint64_t sensor = id_in(json, place, in, "sensor_id");
      const std::string of_sensor = "sensor " + std::to_string(sensor);
      const auto lens = internals.find(sensor);
      const auto size = sizes_.find(sensor);
      const auto uri = uris_.find(id);
      if (lens == internals.end()) json.fail(place, "its " + of_sensor + " is not among 'sensors'");
      if (size == sizes_.end()) json.fail(place, "its " + of_sensor + " is in no file of input cameras");
      if (uri == uris_.end()) {
        // Lists of a part of the project's photos are usual; only where nothing is left, something is wrong.
        if (++unlisted == cameras.size()) json.fail(place, "is in no camera list");
        continue;
      }
      if (page_of_uri(uri->second) != "0") {
        ++pages;
        continue;
      }
      const std::string type = json.text(of_sensor, *lens->second, "type");
      if (type != "perspective" && type != "fisheye") {
        omitted.add(type, InputError(file, of_sensor,
                                     "has a lens of type " + quote(type) + ", perspective and fisheye are read"));
        continue;
      }
      View view;
      view.name = stated_photo_name(file, place, path_of_uri(uri->second));
      view.photo = view.name;
      Matrix3 turn = kTurn;
      view.camera = camera_of(json, of_sensor, *lens->second, size->second, turn);
      view.pose = pose_of(json, place, in, turn);
      scene_.views.push_back(std::move(view));
      moving += in.contains("rolling_shutter") ? 1 : 0;
    }
    omitted.report(scene_);
    scene_.warn(unlisted, "cameras are left out: they are in no camera list, so their photos are unknown");
    scene_.warn(pages, "images are left out: they are further pages of a file");
    scene_.warn(moving, "cameras moved while their photos were read out (rolling_shutter), which is not modelled");
  }

  /// Turns from axes x right, y up, z backward to ours.
  static constexpr Matrix3 kTurn{1, 0, 0, 0, -1, 0, 0, 0, -1};

  /// `turn`, which takes the file's camera axes to ours, is changed to those of the camera that is returned.
  static Camera camera_of(const JsonFile& json, const std::string& place, const Json& in,
                          const std::array<int, 2>& size, Matrix3& turn) {
    Camera camera;
    camera.width = size[0];
    camera.height = size[1];
    const std::vector<double> centre = json.numbers(place, in, "principal_point_px", 2);
    camera.cx = centre[0];
    camera.cy = centre[1];
    if (json.text(place, in, "type") == "fisheye") {
      const std::vector<double> affine = json.numbers(place, in, "affine", 4);
      turn = product(set_fisheye(json.path(), place, {affine[0], affine[1], affine[2], affine[3]},
                                 json.numbers(place, in, "polynomial", 4), camera),
                     turn);
      finish_camera(json.path(), place, camera);
      return camera;
    }
    camera.fx = camera.fy = json.number(place, in, "focal_length_px");
    const std::vector<double> r = json.numbers(place, in, "radial_distortion", 3),
                              t = json.numbers(place, in, "tangential_distortion", 2);
    camera.distortion.k1 = r[0];
    camera.distortion.k2 = r[1];
    camera.distortion.k3 = r[2];
    camera.distortion.p1 = t[0];
    camera.distortion.p2 = t[1];
    finish_camera(json.path(), place, camera);
    return camera;
  }

  static Pose pose_of(const JsonFile& json, const std::string& place, const Json& in, const Matrix3& turn) {
    const std::vector<double> angles = json.numbers(place, in, "orientation_deg", 3),
                              c = json.numbers(place, in, "position", 3);
    const Matrix3 world_from_camera = rotation_from_angles({angles[0], angles[1], angles[2]});
    return finish_pose(json.path(), place, product(turn, transposed(world_from_camera)), {c[0], c[1], c[2]});
  }

  const fs::path& project_;
  SceneFile scene_;
  std::array<std::vector<fs::path>, kOpfFormats.size()> resources_;
  std::map<std::uint64_t, std::string> uris_;
  std::map<std::uint64_t, std::array<int, 2>> sizes_;
};

/// E-books have files of this name, too.
bool is_opf(const fs::path& file) {
  if (lower_case(file.extension().string()) != ".opf") return false;
  const std::string head = first_bytes(file, 256);
  std::string_view text = without_byte_order_mark(head);
  return next_word(text).starts_with('{');
}

SceneFile read_opf(const fs::path& project) {
  SceneFile scene = OpfReader(project).read();
  const fs::path folder = folder_of(project);
  scene.image_folders = {folder / "images", folder / "../images", folder};
  return scene;
}

}  // namespace

extern const SceneFormat kOpf{"OPF",
                              "an OPF project, .opf (or a folder with one)",
                              [](const fs::path& source) { return find_file(source, ".opf", is_opf); },
                              nullptr,
                              {},
                              read_opf};

}  // namespace gpvc::io
