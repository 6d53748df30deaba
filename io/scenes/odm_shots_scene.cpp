// What WebODM's all.zip, unpacked or not, keeps of an OpenDroneMap run: odm_report/shots.geojson, cameras.json and
// odm_georeferencing/coords.txt. opendm/shots.py and opendm/cameras.py of OpenDroneMap.
//
//   {"features": [{"properties": {"filename": "a.jpg", "camera": "v2 ...", "rotation": [..], "translation": [..]}}]}
//
// Camera   "rotation" is OpenSfM's, angle-axis from world to camera; "translation" is the camera's centre, in the
//          projected system. Lens and pixels are OpenSfM's.
// Cameras  cameras.json drops "v2 " from the names. Older runs do not name a shot's camera, only its size and focal
//          length.
// World    the projected system less the offset of coords.txt: that of the run's meshes. Without georeferencing the
//          rotations are scaled along with the coordinates and mean nothing, so coords.txt must be there.
// Archive  members are named as the files are, below a folder where somebody packed the run's folder again.
#include <map>
#include <set>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/files/zip_file.h"
#include "io/scenes/opensfm_scene.h"

namespace gpvc::io {

namespace {

class OdmShotsReader {
 public:
  OdmShotsReader(const JsonFile& shots, const JsonFile& cameras) : shots_(shots), cameras_(cameras) {
    scene_.listing = shots.path();
    if (!cameras.root().is_object() || cameras.root().empty()) cameras.fail("", "expected an object of cameras");
  }

  SceneFile read() {
    if (!shots_.root().is_object()) shots_.fail("", "expected an object");
    const Json& features = shots_.objects("", shots_.root(), "features");
    for (std::size_t i = 0; i < features.size(); ++i) {
      const std::string place = "feature " + std::to_string(i);
      read_shot(place, shots_.object(place, features[i], "properties"));
    }
    omitted_.report(scene_);
    scene_.warn(repeated_, "shots are left out: others have their photo, as overlapping parts of a split run do");
    scene_.warn(other_focal_,
                "shots state another focal length than their camera in cameras.json, as parts of a split "
                "run do; the camera's is read");
    return std::move(scene_);
  }

 private:
  WorldPoint triple(const std::string& place, const Json& object, const char* key) const {
    const std::vector<double> values = shots_.numbers(place, object, key, 3);
    return {values[0], values[1], values[2]};
  }

  double focal_of(const std::string& id, const Json& camera) const {
    const std::string place = "camera " + quote(id);
    return cameras_.number(place, camera, camera.contains("focal") ? "focal" : "focal_x");
  }

  /// The camera's name in cameras.json.
  std::string camera_of(const std::string& place, const Json& shot) const {
    const Json& cameras = cameras_.root();
    if (shot.contains("camera")) {
      std::string id = shots_.text(place, shot, "camera");
      constexpr std::string_view kVersion = "v2 ";
      if (!cameras.contains(id) && id.starts_with(kVersion)) id.erase(0, kVersion.size());
      if (!cameras.contains(id))
        shots_.fail(place, "its camera " + quote(id) + " is not in " + cameras_.path().string());
      return id;
    }
    if (cameras.size() == 1) return cameras.begin().key();
    std::string found;
    for (const auto& [id, camera] : cameras.items()) {
      if (!camera.is_object() || camera.value("width", Json()) != shot.value("width", Json()) ||
          camera.value("height", Json()) != shot.value("height", Json()) ||
          focal_of(id, camera) != shots_.number(place, shot, "focal"))
        continue;
      if (!found.empty()) shots_.fail(place, "its camera could be " + quote(found) + " or " + quote(id));
      found = id;
    }
    if (found.empty())
      shots_.fail(place, "no camera in " + cameras_.path().string() + " has its size and focal length");
    return found;
  }

  void read_shot(const std::string& place, const Json& shot) {
    const std::string id = camera_of(place, shot);
    const auto [camera, fresh] = known_.try_emplace(id);
    if (fresh) camera->second = read_opensfm_camera(cameras_, id, cameras_.root()[id]);
    if (camera->second.refusal) {
      omitted_.add(camera->second.lens, *camera->second.refusal);
      return;
    }
    // Panoramas have none.
    if (!is_spherical(camera->second.camera.distortion.model) && shot.contains("focal") &&
        shots_.number(place, shot, "focal") != focal_of(id, cameras_.root()[id]))
      ++other_focal_;
    View view;
    view.name = stated_photo_name(shots_.path(), place, with_slashes(shots_.text(place, shot, "filename")));
    if (!names_.insert(view.name).second) {
      ++repeated_;
      return;
    }
    view.camera = camera->second.camera;
    const auto rotation = rotation_from_angle_axis(triple(place, shot, "rotation"));
    if (!rotation) shots_.fail(place, "the rotation is not finite");
    view.pose = finish_pose(shots_.path(), place, *rotation, triple(place, shot, "translation"));
    scene_.views.push_back(std::move(view));
  }

  const JsonFile& shots_;
  const JsonFile& cameras_;
  SceneFile scene_;
  std::map<std::string, OpensfmCamera> known_;
  OmittedLenses omitted_;
  std::set<std::string> names_;
  std::size_t other_focal_ = 0, repeated_ = 0;
};

constexpr std::string_view kShots = "odm_report/shots.geojson", kCameras = "cameras.json",
                           kCoords = "odm_georeferencing/coords.txt", kProj = "odm_georeferencing/proj.txt";

/// What the names of an archive's members begin with if it is a run's; nullopt if it is not.
std::optional<std::string> run_in(const ZipFile& archive) {
  for (const auto& [member, number] : archive.members()) {
    if (!member.ends_with(kShots)) continue;
    const std::string folder = member.substr(0, member.size() - kShots.size());
    if ((folder.empty() || folder.ends_with('/')) && archive.has(folder + std::string(kCameras))) return folder;
  }
  return std::nullopt;
}

/// Of a run's folder that has no reconstruction, which says more.
std::optional<fs::path> find_odm_shots(const fs::path& source) {
  if (is_zip(first_bytes(source, 4))) {
    const FileBytes bytes(source, FileBytes::Use::in_places);
    return run_in(ZipFile(source, bytes.view())) ? std::optional(source) : std::nullopt;
  }
  const fs::path shots = is_folder(source) ? source / kShots : source;
  if (lower_case(shots.extension().string()) != ".geojson" || !is_file(shots)) return std::nullopt;
  const fs::path project = folder_of(shots) / "..";
  if (!is_file(project / kCameras)) return std::nullopt;
  if (is_folder(source) && is_file(source / "opensfm" / "reconstruction.json")) return std::nullopt;
  return shots;
}

/// The parts of a run.
struct RunFiles {
  fs::path shots, cameras, coords;
  std::string_view shots_text, cameras_text, coords_text, proj_text;  ///< the last two are empty where there is none
};

SceneFile read_run(const RunFiles& run) {
  SceneFile scene = parse_odm_shots(run.shots, run.shots_text, run.cameras, run.cameras_text);
  if (run.coords_text.empty())
    throw InputError(run.coords, "",
                     "is missing: the shots' positions are less its offset in the run's meshes, and without "
                     "georeferencing their rotations are of no use");
  parse_georeferencing(run.coords, run.coords_text, run.proj_text, scene);
  for (View& view : scene.views) {
    view.pose.centre.x -= scene.offset.x;
    view.pose.centre.y -= scene.offset.y;
  }
  return scene;
}

SceneFile read_archive(const fs::path& file) {
  const FileBytes bytes(file, FileBytes::Use::in_places);
  const ZipFile archive(file, bytes.view());
  const std::string folder = run_in(archive).value();
  const auto text_of = [&](std::string_view member) {
    const std::string name = folder + std::string(member);
    return archive.has(name) ? archive.read(name) : std::string();
  };
  const std::string shots = text_of(kShots), cameras = text_of(kCameras), coords = text_of(kCoords),
                    proj = text_of(kProj);
  SceneFile scene = read_run(
      {file / folder / kShots, file / folder / kCameras, file / folder / kCoords, shots, cameras, coords, proj});
  scene.listing = file;
  scene.files = {file};
  scene.image_folders = {folder_of(file) / "images", folder_of(file)};
  return scene;
}

SceneFile read_odm_shots(const fs::path& found) {
  if (is_zip(first_bytes(found, 4))) return read_archive(found);
  const fs::path project = folder_of(found) / "..", cameras = project / kCameras, coords = project / kCoords;
  const FileBytes shots_bytes(found), cameras_bytes(cameras);
  std::optional<FileBytes> coords_bytes, proj_bytes;
  if (is_file(coords)) coords_bytes.emplace(coords);
  if (is_file(project / kProj)) proj_bytes.emplace(project / kProj);
  const auto text_of = [](const std::optional<FileBytes>& bytes) { return bytes ? bytes->view() : std::string_view(); };
  SceneFile scene = read_run(
      {found, cameras, coords, shots_bytes.view(), cameras_bytes.view(), text_of(coords_bytes), text_of(proj_bytes)});
  scene.files = {found, cameras};
  scene.image_folders = {project / "images", project};
  return scene;
}

}  // namespace

SceneFile parse_odm_shots(const fs::path& shots, std::string_view shots_text, const fs::path& cameras,
                          std::string_view cameras_text) {
  const JsonFile shots_json(shots, shots_text), cameras_json(cameras, cameras_text);
  return OdmShotsReader(shots_json, cameras_json).read();
}

extern const SceneFormat kOdmShots{"OpenDroneMap shots",
                                   "WebODM's all.zip, packed or not (with odm_report/shots.geojson and cameras.json)",
                                   find_odm_shots,
                                   nullptr,
                                   {},
                                   read_odm_shots};

}  // namespace gpvc::io
