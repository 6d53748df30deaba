#include "io/scenes/photo_files.h"

#include <algorithm>
#include <compare>
#include <map>
#include <optional>
#include <set>

#include "io/files/paths.h"
#include "io/scenes/bad_photos.h"
#include "io/scenes/layers.h"
#include "io/scenes/photo_index.h"

namespace gpvc::io {

namespace {

/// The photo in a folder below or beside that of the scene, or beside one where photos usually lie; empty unless there is one
/// such file.
std::string photo_nearby(const SceneFile& scene, const std::string& stated) {
  constexpr std::size_t kMost = 50000;  // to answer within a second
  const fs::path folder = folder_of(scene.listing);
  std::set<fs::path> bases{real_path(folder), real_path(folder / "..")};
  for (const fs::path& usual : scene.image_folders) bases.insert(real_path(usual / ".."));
  PhotoIndex index(folder, false);
  std::size_t count = 0;
  std::error_code ignored;
  for (const fs::path& base : bases)
    for (const auto& below : fs::directory_iterator(base, ignored))
      for (const auto& file : fs::directory_iterator(below.path(), ignored))
        if (++count < kMost) index.add(file.path());
  try {
    return index.match(scene.listing, stated, {}).string();
  } catch (const InputError&) {
    return {};  // several
  }
}

/// The first of the usual folders that holds a photo under its name, else the first that exists.
fs::path usual_folder(const SceneFile& scene, bool allow_none) {
  fs::path existing;
  std::string looked;
  for (const fs::path& folder : scene.image_folders) {
    looked += (looked.empty() ? "" : ", ") + folder.string();
    if (!is_folder(folder)) continue;
    if (existing.empty()) existing = folder;
    for (const View& view : scene.views)
      if (is_file(folder / view.name)) return folder;
  }
  if (existing.empty() && allow_none) return folder_of(scene.listing);
  if (existing.empty()) {
    const std::string near = photo_nearby(scene, scene.views.front().name);
    throw InputError(
        scene.listing, "",
        "the folder of the photos was not found; looked for " + looked + (near.empty() ? "" : "; there is " + near),
        {Cure::photos_folder});
  }
  return existing;
}

/// How well a file fits the path that a view states, compared member by member.
struct Fit {
  bool in_place = false;                 ///< it lies where the path says
  std::size_t tail = 0, exact_tail = 0;  ///< parts in common, in any case of letters and as they stand
  auto operator<=>(const Fit&) const = default;
};

constexpr Fit kInPlace{true, 0, 0};

Fit fit_of_match(const fs::path& file, const std::string& stated) {
  const std::vector<std::string> is = parts_of(file.string()), wanted = parts_of(stated);
  return {false, common_tail(wanted, is, false, true), common_tail(wanted, is, true, false)};
}

/// If one view's photo is missing, another's with the same file name may have been found for both. Such a file goes to
/// the views that it fits best, needed or not.
void assign_shared_photos(SceneFile& scene, const std::vector<bool>& needed, const std::vector<Fit>& fits) {
  std::map<fs::path, std::vector<std::size_t>> finders;
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    if (const fs::path& photo = scene.views[i].photo; !photo.empty())
      finders[real_path(folder_of(photo)) / photo.filename()].push_back(i);
  std::size_t doubtful = 0;
  std::string example;
  for (const auto& [file, views] : finders) {
    Fit best;
    for (const std::size_t i : views) best = std::max(best, fits[i]);
    std::vector<std::size_t> wanting, left_out;
    for (const std::size_t i : views)
      if (fits[i] < best)
        scene.views[i].photo.clear();
      else
        (needed[i] ? wanting : left_out).push_back(i);
    if (wanting.empty()) continue;
    const View& view = scene.views[wanting.front()];
    if (wanting.size() > 1)
      throw InputError(scene.listing, "",
                       "the images '" + view.name + "' and '" + scene.views[wanting[1]].name +
                           "' are the same photo, " + view.photo.string());
    if (left_out.empty() || best.in_place) continue;
    if (doubtful++ == 0)
      example = view.photo.string() + " is taken for '" + view.name + "', not for '" +
                scene.views[left_out.front()].name + "'";
    for (const std::size_t i : left_out) scene.views[i].photo.clear();
  }
  scene.warn(doubtful, "photos could as well be those of views left out: " + example);
}

/// Notes needed photos that are not there, with the file that may be meant.
void note_missing(SceneFile& scene, const std::vector<bool>& needed, const std::vector<std::string>& stated,
                  const PhotoIndex* index, bool folder_named) {
  std::set<fs::path> taken;
  for (const View& view : scene.views) taken.insert(view.photo);
  const auto noted = [&](const View& view) {
    return std::ranges::find(scene.bad_photos, view.name, &BadPhoto::view) != scene.bad_photos.end();
  };
  constexpr std::size_t kMostSearched = 20;  // each of them takes a look at all files
  std::size_t searched = 0;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    if (!needed[i] || !scene.views[i].photo.empty() || noted(scene.views[i])) continue;
    std::string near = searched == 0 && !folder_named ? photo_nearby(scene, stated[i]) : std::string();
    if (index && ++searched <= kMostSearched && near.empty()) near = index->near(stated[i], taken);
    forget_photo(scene, i, true, BadPhoto::Problem::missing, near.empty() ? "" : "there is " + near);
  }
}

}  // namespace

fs::path find_photos(SceneFile& scene, const std::vector<bool>& needed, const SceneOptions& options) {
  std::vector<std::string> stated;
  std::vector<Fit> fits(scene.views.size(), kInPlace);
  std::size_t open = 0;
  for (View& view : scene.views) {
    stated.push_back(view.photo.empty() ? view.name : view.photo.string());
    if (!view.photo.empty() && !options.images_dir) {
      const fs::path there = folder_of(scene.listing) / view.photo;  // an absolute path stands for itself
      view.photo = is_file(there) ? there : fs::path();
    } else {
      view.photo.clear();
    }
    open += view.photo.empty() ? 1 : 0;
  }
  fs::path folder = folder_of(scene.listing);
  std::optional<PhotoIndex> index;
  if (open > 0) {
    if (options.images_dir && !is_folder(*options.images_dir))
      throw InputError(*options.images_dir, "", "is not a folder; it was given as the folder of the photos");
    folder = options.images_dir ? *options.images_dir : usual_folder(scene, options.allow_missing_photos);
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
      View& view = scene.views[i];
      if (!view.photo.empty()) continue;
      const fs::path named = folder / view.name;
      if (parts_of(stated[i]).size() <= parts_of(view.name).size() && is_file(named)) {
        view.photo = named;
        continue;
      }
      // The scene file's own folder may hold anything below it, so only a folder meant for photos is searched in depth.
      std::error_code ignored;
      const bool deep = options.images_dir || !fs::equivalent(folder, folder_of(scene.listing), ignored);
      if (!index) index.emplace(folder, deep);
      if (!deep && named.parent_path() != folder) index->add(named);
      try {
        view.photo = index->match(scene.listing, stated[i], named);
        fits[i] = fit_of_match(view.photo, stated[i]);
      } catch (const InputError& error) {
        forget_photo(scene, i, needed[i], BadPhoto::Problem::ambiguous, reason_of(error, scene.listing));
      }
    }
  }
  assign_shared_photos(scene, needed, fits);
  if (!options.allow_missing_photos)
    note_missing(scene, needed, stated, index ? &*index : nullptr, options.images_dir.has_value());
  return folder;
}

void use_texture_layers(SceneFile& scene) {
  FolderNames names;
  std::string example;
  for (View& view : scene.views) {
    if (view.photo.empty()) continue;
    const fs::path layer = names.find_layer(view.photo, "texture");
    if (layer.empty()) continue;
    if (example.empty()) example = layer.string();
    scene.photos_of_layers[layer] = view.photo;
    view.photo = layer;
  }
  scene.warn(scene.photos_of_layers.size(),
             "photos are replaced by their texture layers of RealityCapture, among them " + example);
}

}  // namespace gpvc::io
