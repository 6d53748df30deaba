#include "io/scene_file.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>

#include "io/image_file.h"
#include "io/io.h"

namespace gpvc {

namespace {

namespace fs = std::filesystem;

fs::path find_images(const SceneFile& scene, const SceneOptions& options) {
  std::error_code ignored;
  if (options.images_dir) {
    if (!fs::is_directory(*options.images_dir, ignored))
      throw InputError(*options.images_dir, "", "is not a folder; it was given as the folder of the photos");
    return *options.images_dir;
  }
  std::string looked;
  for (const fs::path& folder : scene.image_folders) {
    if (fs::is_directory(folder, ignored)) return folder;
    looked += (looked.empty() ? "" : ", ") + folder.string();
  }
  throw InputError(scene.listing, "", "the folder of the photos was not found; looked for " + looked);
}

void order_by_name(SceneFile& scene) {
  std::sort(scene.views.begin(), scene.views.end(),
            [](const View& a, const View& b) { return a.name < b.name; });
  const auto twice = std::adjacent_find(scene.views.begin(), scene.views.end(),
                                        [](const View& a, const View& b) { return a.name == b.name; });
  if (twice != scene.views.end())
    throw InputError(scene.listing, "", "lists the image '" + twice->name + "' twice");
}

/// Photos exist, and their headers agree with the cameras.
void check_photos(const SceneFile& scene, const fs::path& folder) {
  std::string named;
  std::size_t missing = 0;
  for (const View& view : scene.views) {
    std::error_code ignored;
    if (fs::is_regular_file(view.photo, ignored)) continue;
    constexpr std::size_t kHandful = 5;
    if (++missing <= kHandful) named += (named.empty() ? "" : ", ") + view.name;
    if (missing == kHandful + 1) named += ", ...";
  }
  if (missing > 0)
    throw InputError(scene.listing, "",
                     std::to_string(missing) + " of " + std::to_string(scene.views.size()) +
                         " photos are not in " + folder.string() + ": " + named);
  // Errors are collected so that the first view's is the one reported, whatever the threads did.
  std::vector<std::string> problem(scene.views.size());
  tbb::parallel_for(std::size_t{0}, scene.views.size(), [&](std::size_t i) {
    const View& view = scene.views[i];
    try {
      const ImageSize size = read_image_size(view.photo);
      if (size.width != view.camera.width || size.height != view.camera.height)
        problem[i] = "is " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                     " pixels, its camera in " + scene.listing.parent_path().string() +
                     " is calibrated for " + std::to_string(view.camera.width) + " x " +
                     std::to_string(view.camera.height);
    } catch (const InputError& error) {
      problem[i] =
          error.what() + view.photo.string().size() + 2;  // without the file's name, added again below
    }
  });
  for (std::size_t i = 0; i < problem.size(); ++i)
    if (!problem[i].empty()) throw InputError(scene.views[i].photo, "", problem[i]);
}

/// x' = x / N holds exactly for pixel centres at (0.5, 0.5); what is left over at the right and bottom is
/// cut.
Camera reduced(const View& view, int factor) {
  Camera camera = view.camera;
  camera.width /= factor;
  camera.height /= factor;
  if (camera.width < 1 || camera.height < 1)
    throw InputError(view.photo, "", "is too small to be reduced by " + std::to_string(factor));
  camera.fx /= factor;
  camera.fy /= factor;
  camera.cx /= factor;
  camera.cy /= factor;
  return camera;
}

}  // namespace

Scene read_scene(const fs::path& source, const SceneOptions& options) {
  if (options.downscale < 1) throw std::invalid_argument("SceneOptions::downscale must be at least 1");
  std::error_code ignored;
  if (!fs::exists(source, ignored)) throw InputError(source, "", "does not exist");
  std::optional<SceneFile> found;
  if (fs::is_directory(source, ignored)) found = read_colmap(source);
  if (!found)
    throw InputError(
        source, "",
        "is no scene: expected a COLMAP model, a folder with cameras.bin and images.bin or cameras.txt and "
        "images.txt, there or in sparse/0, sparse or colmap below it");
  SceneFile& scene = *found;
  if (scene.views.empty()) throw InputError(scene.listing, "", "lists no image");
  order_by_name(scene);
  const fs::path folder = find_images(scene, options);
  for (View& view : scene.views) view.photo = folder / view.name;
  check_photos(scene, folder);
  for (View& view : scene.views) view.camera = reduced(view, options.downscale);
  return {source, std::move(scene.views)};
}

}  // namespace gpvc
