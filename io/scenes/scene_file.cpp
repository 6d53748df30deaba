#include "io/scenes/scene_file.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "io/bands/band_files.h"
#include "io/bands/band_set.h"
#include "io/bands/band_views.h"
#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/files/zip_file.h"
#include "io/images/mask_file.h"
#include "io/scene_files.h"
#include "io/scenes/bad_photos.h"
#include "io/scenes/fisheye_views.h"
#include "io/scenes/panorama_views.h"
#include "io/scenes/photo_files.h"
#include "io/scenes/xml_file.h"

namespace gpvc::io {

// One a format, each defined in its NAME_scene.cpp.
extern const SceneFormat kAlicevision, kBlocksExchange, kBundler, kCam, kColmap, kMetashape, kMicmac, kMve, kNvm,
    kOdmShots, kOpenmvg, kOpenmvs, kOpensfm, kOpf, kPix4d, kRealityCsv, kRealityXmp, kTransforms;

std::span<const SceneFormat* const> scene_formats() {
  static constexpr const SceneFormat* kFormats[] = {&kAlicevision, &kBlocksExchange, &kBundler,   &kCam, &kColmap,
                                                    &kMetashape,   &kMicmac,         &kMve,       &kNvm, &kOdmShots,
                                                    &kOpenmvg,     &kOpenmvs,        &kOpensfm,   &kOpf, &kPix4d,
                                                    &kRealityCsv,  &kRealityXmp,     &kTransforms};
  return kFormats;
}

namespace {

/// A source whose format is known.
struct SceneSource {
  const SceneFormat* format;
  fs::path path;  ///< what the format's reader takes
};

/// The folder of a COLMAP model of which one file is missing, if there is one.
std::optional<std::string> incomplete_colmap(const fs::path& source) {
  for (const char* below : {".", "0", "sparse", "sparse/0", "colmap", "colmap/sparse/0"})
    for (const char* extension : {".bin", ".txt"}) {
      const fs::path folder = below == std::string_view(".") ? source : source / below;
      const bool cameras = is_file(folder / (std::string("cameras") + extension));
      if (cameras != is_file(folder / (std::string("images") + extension)))
        return std::string("holds a COLMAP model without ") + (cameras ? "images" : "cameras") + extension +
               (folder == source ? "" : " in " + folder.string()) +
               ": copy the model whole, or let COLMAP export it again (File > Export model)";
    }
  return std::nullopt;
}

/// True for the files of Pix4Dmapper's parameters that have poses or lenses but not both, and a folder with one.
bool is_part_of_pix4d(const fs::path& source) {
  const auto is_part = [](const fs::path& file) {
    const std::string name = lower_case(file.filename().string());
    for (const char* part :
         {"calibrated_external_camera_parameters.txt", "calibrated_external_camera_parameters_wgs84.txt",
          "calibrated_images_position.txt", "calibrated_internal_camera_parameters.cam"})
      if (name.ends_with(part)) return true;
    return false;
  };
  if (!is_folder(source)) return is_part(source);
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(source, ignored))
    if (is_part(entry.path())) return true;
  return false;
}

/// True for WebODM's camera shots alone, and a folder with them.
bool is_part_of_odm(const fs::path& source) {
  const auto is_shots = [](const fs::path& file) { return file.filename() == "shots.geojson" && is_file(file); };
  return is_shots(source) || is_shots(source / "shots.geojson") || is_shots(source / "odm_report" / "shots.geojson");
}

/// A scene that lies one folder above or below, of which a source that is none may be a part.
std::optional<std::string> scene_nearby(const fs::path& source) {
  std::vector<fs::path> near;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(source, ignored))
    if (is_folder(entry.path())) near.push_back(entry.path());
  std::ranges::sort(near);
  constexpr std::size_t kMost = 100;  // to answer within seconds
  near.resize(std::min(near.size(), kMost));
  const fs::path here = fs::absolute(source, ignored).lexically_normal();
  near.push_back((here.has_filename() ? here : here.parent_path()).parent_path());
  for (const fs::path& folder : near)
    for (const SceneFormat* format : scene_formats()) try {
        if (const auto found = format->find(folder))
          return "is no scene, but " + found->string() + " is one (" + format->name + "); give that";
      } catch (const InputError&) {  // several of this format: none that could be named
      }
  return std::nullopt;
}

/// True for the poses of LLFF and of the NeRF data sets made with it, and a folder with them.
bool is_llff(const fs::path& source) {
  const auto is_poses = [](const fs::path& file) { return file.filename() == "poses_bounds.npy" && is_file(file); };
  return is_poses(source) || is_poses(source / "poses_bounds.npy");
}

/// Throws where Git LFS left a pointer instead of a file that could be the scene's.
void refuse_pointers(const fs::path& source) {
  constexpr std::uintmax_t kMostBytes = 1024;  // of a pointer, as Git LFS specifies
  std::error_code ignored;
  if (!is_folder(source)) return refuse_lfs_pointer(source, first_bytes(source, 256));
  for (const auto& entry : fs::directory_iterator(source, ignored))
    if (is_file(entry.path()) && entry.file_size(ignored) < kMostBytes)
      refuse_lfs_pointer(entry.path(), first_bytes(entry.path(), 256));
}

/// What to do with projects of other programs, which are told by their name: a sentence's end, or nothing.
std::optional<std::string> advice_on_project(const fs::path& source) {
  constexpr const char* kReality =
      "is a RealityScan project; export its cameras as .xmp files beside the photos, or the camera parameters as .csv "
      "(Alignment > Export > Registration)";
  constexpr std::pair<std::string_view, const char*> kProjects[] = {
      {".psx", "is a Metashape project; export its cameras as XML (File > Export > Export Cameras)"},
      {".psz", "is a Metashape project; export its cameras as XML (File > Export > Export Cameras)"},
      {".rcproj", kReality},
      {".rsproj", kReality},
      {".ccm", "is a ContextCapture project; export its block as BlocksExchange XML (Export > Export block)"},
      {".p4d", "is a Pix4Dmapper project; give the folder 1_initial/params of its results"},
      {".mg", "is a Meshroom project; give cameras.sfm of its StructureFromMotion, in MeshroomCache"},
      {".db", "is COLMAP's database, which has no poses; give the project's folder, or sparse/0"}};
  const std::string extension = lower_case(source.extension().string());
  for (const auto& [of_project, advice] : kProjects)
    if (extension == of_project) return advice;
  return std::nullopt;
}

/// What to do with a source that is no scene, if that is known: a sentence's end.
std::optional<std::string> advice_on(const fs::path& source) {
  if (is_part_of_pix4d(source))
    return std::string(is_folder(source) ? "holds" : "is") +
           " only part of Pix4Dmapper's parameters; give *_calibrated_camera_parameters.txt, which it writes beside "
           "them in 1_initial/params (Processing Options > 1. Initial Processing > Calibration > Export: Camera "
           "Internals and Externals, AAT, BBA)";
  if (is_part_of_odm(source))
    return std::string(is_folder(source) ? "holds" : "is") +
           " only part of an OpenDroneMap run: its cameras.json and odm_georeferencing/coords.txt are needed too; give "
           "WebODM's all.zip or the run's folder";
  if (is_llff(source))
    return std::string(is_folder(source) ? "holds" : "is") +
           " poses of LLFF (poses_bounds.npy), which name no photos; give the COLMAP model that they were made from, "
           "sparse/0 as a rule";
  if (is_folder(source)) {
    const std::optional<std::string> incomplete = incomplete_colmap(source);
    return incomplete ? incomplete : scene_nearby(source);
  }
  if (const std::string name = source.filename().string();
      name == "cameras.bin" || name == "cameras.txt" || name == "images.bin" || name == "images.txt")
    if (const auto incomplete = incomplete_colmap(folder_of(source)))
      return "is part of a COLMAP model: the folder " + *incomplete;
  const std::string head = first_bytes(source, 4);
  if (is_zip(head)) return "is a zip archive of which nothing is read as it is; unpack it";
  if (head.starts_with("ply")) return "is a mesh; the scene goes before it";
  if (head.starts_with("\xFF\xFE") || head.starts_with("\xFE\xFF")) return "is text in UTF-16; save it as UTF-8";
  return std::nullopt;
}

/// Says what a source that is not a scene is instead, from its first bytes.
std::string describe_other(const fs::path& source) {
  constexpr const char* kUnknown = "is no scene";
  if (is_folder(source)) return kUnknown;
  const std::string head = first_bytes(source, 256);
  const std::size_t text = head.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (head.empty()) return "is empty";
  if (head.starts_with("\xFF\xD8\xFF") || head.starts_with("\x89PNG") || head.starts_with("II*") ||
      head.starts_with("MM"))
    return "is a photo";
  const char first = text == std::string::npos ? '\0' : head[text];
  if (const std::string root = xml_root(source); !root.empty() && first == '<')
    return "is XML of another program, whose root is " + quote(root);
  if (first == '[' || first == '{') return "is JSON of another program, or not named .json";
  return kUnknown;
}

/// What formats expect of a file of this extension; where none reads it, and of a folder, the formats alone: what all of
/// them expect fills a screen.
std::string expectation_of(const fs::path& source) {
  const std::string extension = is_folder(source) ? "" : lower_case(source.extension().string());
  std::string names, likely;
  for (const SceneFormat* format : scene_formats()) {
    names.append(names.empty() ? "" : ", ").append(format->name);
    if (!extension.empty() && std::string_view(format->expects).find(extension) != std::string_view::npos)
      likely.append(likely.empty() ? "" : "; ").append(format->expects);
  }
  return likely.empty() ? "the cameras of one of these: " + names : likely;
}

SceneSource recognize(const fs::path& source) {
  if (const auto advice = advice_on_project(source)) throw InputError(source, "", *advice);
  std::optional<SceneSource> found;
  for (const SceneFormat* format : scene_formats()) {
    const std::optional<fs::path> path = format->find(source);
    if (!path) continue;
    if (found)
      throw InputError(source, "",
                       std::string("holds both a ") + found->format->name + " scene (" + found->path.string() +
                           ") and a " + format->name + " scene (" + path->string() + "); name the one that is meant");
    found = SceneSource{format, *path};
  }
  if (found) return *found;
  refuse_pointers(source);
  if (const auto advice = advice_on(source)) throw InputError(source, "", *advice);
  throw InputError(source, "", describe_other(source) + ": expected " + expectation_of(source));
}

SceneFile read_file(const SceneSource& source) {
  if (source.format->read != nullptr) return source.format->read(source.path);
  const FileBytes bytes(source.path);
  SceneFile scene = source.format->parse(source.path, bytes.view());
  const fs::path folder = folder_of(source.path);
  for (const char* name : source.format->image_folders)
    if (name != nullptr) scene.image_folders.push_back(folder / name);
  scene.image_folders.push_back(folder);
  return scene;
}

/// If the scene's file is a link, its photos may lie beside the file that it links to.
void add_folders_behind_link(SceneFile& scene) {
  std::error_code failed;
  const fs::path here = fs::absolute(folder_of(scene.listing)).lexically_normal();
  const fs::path real = fs::canonical(scene.listing, failed).parent_path();
  if (failed || here == real) return;
  for (const fs::path& folder : std::vector<fs::path>(scene.image_folders))
    if (const fs::path relative = fs::absolute(folder).lexically_normal().lexically_relative(here); !relative.empty())
      scene.image_folders.push_back(real / relative);
}

/// Takes out views that say what another one says, as scripts that append to a list leave them.
void leave_out_repeated(SceneFile& scene) {
  std::ranges::stable_sort(scene.views, {}, &View::name);
  std::string example;
  std::vector<View> kept;
  for (View& view : scene.views) {
    const View* before = kept.empty() ? nullptr : &kept.back();
    const bool again = before != nullptr && before->name == view.name && before->photo == view.photo &&
                       before->camera == view.camera && before->pose.rotation == view.pose.rotation &&
                       before->pose.centre == view.pose.centre;
    if (again && example.empty()) example = view.name;
    if (!again) kept.push_back(std::move(view));
  }
  scene.warn(scene.views.size() - kept.size(),
             "images are left out that repeat others with the same camera and pose, as " + quote(example));
  scene.views = std::move(kept);
}

/// The views that the stages work with, by name, and for each which one of the file's it comes from.
struct FinalViews {
  std::vector<View> views;
  std::vector<std::size_t> sources;
};

FinalViews final_views(const std::vector<View>& of_file, const fs::path& listing, bool whole_fisheyes) {
  std::vector<std::pair<View, std::size_t>> all;
  for (std::size_t i = 0; i < of_file.size(); ++i)
    for (View& part : views_of(of_file[i]))
      for (View& view : whole_fisheyes ? std::vector{part} : fisheye_views(part)) all.emplace_back(std::move(view), i);
  std::ranges::sort(all, {}, [](const auto& view) -> const std::string& { return view.first.name; });
  FinalViews result;
  for (auto& [view, source] : all) {
    if (!result.views.empty() && result.views.back().name == view.name)
      throw InputError(listing, "", "lists two images of which '" + view.name + "' would be a view");
    result.views.push_back(std::move(view));
    result.sources.push_back(source);
  }
  return result;
}

/// Which of the file's views need their photo.
std::vector<bool> needed_views(const SceneFile& file, const SceneOptions& options) {
  if (!options.needed) return std::vector<bool>(file.views.size(), true);
  const FinalViews all = final_views(file.views, file.listing, options.whole_fisheyes);
  const std::vector<bool> wanted = options.needed(all.views);
  std::vector<bool> needed(file.views.size(), false);
  for (std::size_t v = 0; v < wanted.size(); ++v)
    if (wanted[v]) needed[all.sources[v]] = true;
  return needed;
}

/// x' = x / N holds exactly for pixel centres at (0.5, 0.5); what is left over at the right and bottom is cut.
Camera reduced(const View& view, int factor) {
  Camera camera = view.camera;
  // Both of its sides must meet.
  if (is_panorama(view) && camera.width % factor != 0)
    throw InputError(view.photo, "",
                     "is a panorama " + std::to_string(camera.width) + " pixels wide, which cannot be reduced by " +
                         std::to_string(factor) + ": expected a factor of its width");
  if (camera.width < factor || camera.height < factor)
    throw InputError(view.photo, "", "is too small to be reduced by " + std::to_string(factor));
  return reduced_camera(camera, factor);
}

}  // namespace

Camera reduced_camera(Camera camera, int factor) {
  camera.width /= factor;
  camera.height /= factor;
  camera.fx /= factor;
  camera.fy /= factor;
  camera.cx /= factor;
  camera.cy /= factor;
  return camera;
}

Scene read_scene(const fs::path& source, const SceneOptions& options) {
  if (options.downscale < 1) throw std::invalid_argument("SceneOptions::downscale must be at least 1");
  std::error_code ignored;
  if (!fs::exists(source, ignored) && !kMve.find(source)) throw InputError(source, "", "does not exist");
  const SceneSource found = recognize(source);
  SceneFile file = read_file(found);
  if (file.views.empty()) {
    std::string reasons;
    for (const std::string& warning : file.warnings) reasons += (reasons.empty() ? ": " : "; ") + warning;
    throw InputError(file.listing, "", "lists no image with a pose that can be used" + reasons);
  }
  leave_out_repeated(file);
  normalize_names(file);
  add_folders_behind_link(file);
  std::vector<bool> needed = needed_views(file, options);
  const fs::path folder = find_photos(file, needed, options);
  use_texture_layers(file);
  find_band_files(file, needed, options);
  forget_truncated_photos(file, needed);
  fit_cameras(file, needed);
  join_band_views(file, needed, options);
  if (options.skip_bad_photos) forget_damaged_photos(file, needed);
  refuse_bad_photos(file, needed, folder, options.skip_bad_photos);
  Scene scene;
  if (!options.whole_fisheyes) scene.circle_photos = find_image_circles(file.views, needed);
  find_masks(file, options);
  find_bands(file, needed, options);
  scene.source = source;
  for (View& view : file.views) {
    if (view.camera.width != 0) view.camera = reduced(view, options.downscale);
    view.reduction = options.downscale;
  }
  scene.views = final_views(file.views, file.listing, options.whole_fisheyes).views;
  scene.srs = std::move(file.srs);
  scene.offset = file.offset;
  scene.other_frames = std::move(file.other_frames);
  scene.reference = std::move(file.reference);
  scene.format = found.format->name;
  scene.read_from = found.path;
  scene.files = std::move(file.files);
  if (scene.files.empty()) scene.files = {file.listing};
  scene.warnings = std::move(file.warnings);
  scene.bad_photos = std::move(file.bad_photos);
  scene.bands = std::move(file.bands);
  scene.band_places = std::move(file.band_places);
  return scene;
}

}  // namespace gpvc::io
