#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "app/interrupt.h"
#include "app/rephotography.h"
#include "app/scene_input.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

const char* target_name(SceneTarget target) {
  constexpr const char* kNames[] = {"colmap", "cam", "mvs"};
  return kNames[static_cast<std::size_t>(target)];
}

bool is_jpeg(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension == ".jpg" || extension == ".jpeg";
}

// Named for the first view that loses something, before a photo is read.
void refuse_lost_terms(const Scene& scene, const std::vector<ViewId>& used, SceneTarget target) {
  for (const ViewId id : used)
    if (const auto lost = lost_term(target, scene.views[index(id)].camera))
      throw InputError(
          scene.source, scene.views[index(id)].name,
          fmt::format("its camera has {}, which the format '{}' cannot state; --undistort writes photos "
                      "and cameras without distortion",
                      *lost, target_name(target)));
}

/// The photos and the scene that are read must never be replaced by what is made of them, and what is there
/// of somebody else's not without --force.
void refuse_overwriting(const ConvertOptions& options, const Scene& scene,
                        const std::vector<fs::path>& places) {
  std::vector<fs::path> made = places;
  if (options.target == SceneTarget::cam)
    for (fs::path place : places) made.push_back(place.replace_extension(".cam"));
  if (options.target == SceneTarget::mvs) made.emplace_back("scene.mvs");
  if (options.target == SceneTarget::colmap)
    for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"})
      made.push_back(fs::path("sparse") / name);
  std::set<fs::path> sources{fs::weakly_canonical(scene.source)};
  for (const View& view : scene.views) {
    sources.insert(fs::weakly_canonical(view.photo));
    if (!view.mask.empty()) sources.insert(fs::weakly_canonical(view.mask));
  }
  for (const fs::path& place : made) {
    const fs::path file = options.out / place;
    std::error_code ignored;
    if (!fs::exists(file, ignored)) continue;
    if (sources.contains(fs::weakly_canonical(file)))
      throw OutputError(
          file, "belongs to the scene that is converted; choose another folder than " + options.out.string());
    if (!options.force)
      throw OutputError(file, "exists already; choose another folder, or give --force to replace it");
  }
}

void copy_photo(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::copy_file(from, to, failed);
  if (failed) throw OutputError(to, "cannot be copied from " + from.string() + ": " + failed.message());
}

// The frame's photo; the frame shows all that a rectilinear photo of its size can.
void write_undistorted(const Image& photo, const Camera& camera, const fs::path& file, int quality) {
  std::vector<std::uint8_t> inside;
  const Image image = undistort_photo(photo, camera, inside);
  write_image(file, image, is_jpeg(file) ? ImageFormat::jpg : ImageFormat::png, quality);
}

void convert(const ConvertOptions& options, OutputFolder& folder, Console& console) {
  RunRecord record;
  Stage reading(console, record, "read");
  const SceneOptions reader = options.input.reader_options();
  Scene scene = read_scene(options.input.scene, reader);
  for (const std::string& warning : scene.warnings) console.warning(warning);
  const std::vector<ViewId> used = used_views(scene, options.input.views, options.input.exclude_views);
  reading.finish(fmt::format("{} views", used.size()));

  Scene written = scene;
  if (options.undistort)
    for (View& view : written.views) view.camera.distortion = {};
  refuse_lost_terms(written, used, options.target);
  std::vector<fs::path> places = photo_places(options.target, written, used);
  const bool decoded = options.undistort || options.input.downscale > 1;
  if (decoded)
    for (fs::path& place : places)
      if (!is_jpeg(place)) place.replace_extension(".png");
  refuse_overwriting(options, scene, places);

  Stage photos(console, record, "photos", "photos");
  PhotoCache cache(scene, reader, 0);
  for (std::size_t i = 0; i < used.size(); ++i) {
    photos.progress(i, used.size());
    const View& view = scene.views[index(used[i])];
    const fs::path file = folder.file(places[i]);
    if (options.undistort)
      write_undistorted(*cache.photo(used[i]), view.camera, file, options.quality);
    else if (decoded)
      write_image(file, *cache.photo(used[i]), is_jpeg(file) ? ImageFormat::jpg : ImageFormat::png,
                  options.quality);
    else
      copy_photo(view.photo, file);
  }
  photos.finish(options.undistort ? "undistorted" : decoded ? "reduced" : "copied");

  if (options.target == SceneTarget::colmap) folder.file("sparse/cameras.txt");
  write_scene(options.target, written, used, places, folder.in_making());
  folder.promise_all();
  Json json = {{"scene", options.input.scene.string()},
               {"format", target_name(options.target)},
               {"undistort", options.undistort},
               {"downscale", options.input.downscale}};
  record.counts = {{"views", used.size()}};
  write_run_json(folder, {"convert", options.common, json}, record);
}

}  // namespace

void run_convert(const ConvertOptions& options, Console& console) {
  OutputFolder folder(options.out, options.force);
  try {
    convert(options, folder, console);
    folder.publish();
  } catch (const OutputError& e) {
    throw std::runtime_error(folder.with_final_names(e.what()));
  }
  console.result((options.out / (options.target == SceneTarget::mvs ? "scene.mvs" : "")).string());
}

}  // namespace gpvc
