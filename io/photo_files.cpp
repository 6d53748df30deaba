#include "io/photo_files.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <unordered_map>

#include "io/image_file.h"
#include "io/text_scan.h"

namespace gpvc {

namespace {

namespace fs = std::filesystem;

/// "a/b/../c" as {a, c}; leading "..", "/" and "C:" stay as parts of their own.
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  for (const fs::path& part : fs::path(path).lexically_normal())
    if (!part.empty() && part != ".") parts.push_back(part.string());
  return parts;
}

bool is_drive(const std::string& part) { return part.size() == 2 && part[1] == ':'; }

/// Fit to be joined to a folder, and to name outputs.
bool is_plain(const std::string& name) {
  const std::vector<std::string> parts = parts_of(name);
  return !parts.empty() && name.front() != '/' && !is_drive(parts.front()) && parts.front() != ".." &&
         name.find("/..") == std::string::npos;
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool has_image_extension(const fs::path& name) {
  const std::string extension = lower_case(name.extension().string());
  for (const char* known : {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".exr", ".dng", ".webp", ".bmp", ".jp2",
                            ".ppm", ".hdr", ".arw", ".cr2", ".nef", ".heic"})
    if (extension == known) return true;
  return false;
}

/// The files in and below a folder, by file name in small letters, and by that without extension.
class PhotoIndex {
 public:
  PhotoIndex(const fs::path& folder, bool deep) : folder_(folder) {
    std::error_code error;
    constexpr auto kOptions = fs::directory_options::skip_permission_denied;
    if (deep) {
      for (auto it = fs::recursive_directory_iterator(folder, kOptions, error);
           !error && it != fs::recursive_directory_iterator(); it.increment(error))
        add(it->path());
    } else {
      for (auto it = fs::directory_iterator(folder, kOptions, error);
           !error && it != fs::directory_iterator(); it.increment(error))
        add(it->path());
    }
  }

  /// Empty when none fits; throws when several do equally well.
  fs::path match(const fs::path& listing, const std::string& wanted) const {
    const std::vector<std::string> tail = parts_of(wanted);
    const fs::path name = tail.back();
    for (const bool exact : {true, false})
      if (const fs::path found = best(listing, wanted, tail, by_name_, lower_case(tail.back()), exact, false);
          !found.empty())
        return found;
    if (has_image_extension(name)) return {};
    return best(listing, wanted, tail, by_stem_, lower_case(tail.back()), false, true);
  }

 private:
  using Index = std::unordered_map<std::string, std::vector<fs::path>>;

  void add(const fs::path& path) {
    if (!is_file(path)) return;
    by_name_[lower_case(path.filename().string())].push_back(path);
    if (has_image_extension(path)) by_stem_[lower_case(path.stem().string())].push_back(path);
  }

  /// Parts that agree from the end; the file name itself agrees already but for case and extension.
  static std::size_t common_tail(const std::vector<std::string>& a, const std::vector<std::string>& b,
                                 bool exact, bool by_stem) {
    std::size_t common = 0;
    while (common < a.size() && common < b.size()) {
      const std::string &x = a[a.size() - 1 - common], &y = b[b.size() - 1 - common];
      const bool same = exact ? x == y : lower_case(x) == lower_case(y) || (by_stem && common == 0);
      if (!same) break;
      ++common;
    }
    return common;
  }

  fs::path best(const fs::path& listing, const std::string& wanted, const std::vector<std::string>& tail,
                const Index& index, const std::string& key, bool exact, bool by_stem) const {
    const auto candidates = index.find(key);
    if (candidates == index.end()) return {};
    std::size_t longest = 0;
    std::vector<fs::path> found;
    for (const fs::path& path : candidates->second) {
      const std::size_t common = common_tail(tail, parts_of(path.string()), exact, by_stem);
      if (common == 0 || common < longest) continue;
      if (common > longest) found.clear();
      longest = common;
      found.push_back(path);
    }
    if (found.size() < 2) return found.empty() ? fs::path() : found.front();
    std::sort(found.begin(), found.end());
    std::string names;
    for (std::size_t i = 0; i < found.size() && i < 5; ++i)
      names += (i == 0 ? "" : ", ") + found[i].lexically_relative(folder_).string();
    throw InputError(listing, "",
                     "the photo '" + wanted + "' could be any of " + std::to_string(found.size()) +
                         " files in " + folder_.string() + ": " + names + (found.size() > 5 ? ", ..." : ""));
  }

  fs::path folder_;
  Index by_name_, by_stem_;
};

/// Of the usual folders the first in which a photo lies under its name, else the first that exists.
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
  if (existing.empty())
    throw InputError(scene.listing, "", "the folder of the photos was not found; looked for " + looked);
  return existing;
}

/// A photo at another size than its camera's: the same picture when one factor explains both sides, whichever
/// way they were rounded. An equal side rounds nothing and allows no other.
bool same_shape(int width, int height, const Camera& camera) {
  if ((width == camera.width) != (height == camera.height)) return false;
  // width = factor * camera.width, rounded to nearest or cut: factor lies in [width - 1/2, width + 1).
  const double low = std::max((width - 0.5) / camera.width, (height - 0.5) / camera.height);
  const double high = std::min((width + 1.0) / camera.width, (height + 1.0) / camera.height);
  return low < high;
}

void scale(Camera& camera, int width, int height) {
  const double x = static_cast<double>(width) / camera.width, y = static_cast<double>(height) / camera.height;
  camera.fx *= x;
  camera.cx *= x;
  camera.fy *= y;
  camera.cy *= y;
  camera.width = width;
  camera.height = height;
}

}  // namespace

void settle_names(SceneFile& scene) {
  const bool plain =
      std::all_of(scene.views.begin(), scene.views.end(), [](const View& v) { return is_plain(v.name); });
  if (!plain) {
    std::vector<std::vector<std::string>> names;
    for (const View& view : scene.views) names.push_back(parts_of(view.name));
    std::size_t shared = names.front().empty() ? 0 : names.front().size() - 1;
    for (const auto& name : names) {
      std::size_t same = 0;
      while (same < shared && same + 1 < name.size() && name[same] == names.front()[same]) ++same;
      shared = same;
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      std::string joined;
      for (std::size_t p = shared; p < names[i].size(); ++p) {
        const std::string& part = names[i][p];
        if (part == ".." || part == "/" || is_drive(part)) continue;
        joined += (joined.empty() ? "" : "/") + part;
      }
      if (joined.empty())
        throw InputError(scene.listing, "", "the image '" + scene.views[i].name + "' has no file name");
      scene.views[i].name = joined;
    }
  }
  std::sort(scene.views.begin(), scene.views.end(),
            [](const View& a, const View& b) { return a.name < b.name; });
  const auto twice = std::adjacent_find(scene.views.begin(), scene.views.end(),
                                        [](const View& a, const View& b) { return a.name == b.name; });
  if (twice != scene.views.end())
    throw InputError(scene.listing, "", "lists the image '" + twice->name + "' twice");
}

fs::path find_photos(SceneFile& scene, const SceneOptions& options) {
  std::vector<std::string> stated;
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
  if (open > 0) {
    if (options.images_dir && !is_folder(*options.images_dir))
      throw InputError(*options.images_dir, "", "is not a folder; it was given as the folder of the photos");
    folder = options.images_dir ? *options.images_dir : usual_folder(scene, options.allow_missing_photos);
    std::optional<PhotoIndex> index;
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
      View& view = scene.views[i];
      if (!view.photo.empty()) continue;
      view.photo = folder / view.name;
      if (is_file(view.photo)) continue;
      if (!index) {
        // Beside the scene's file anything may lie below: only a folder meant for photos is searched in
        // depth.
        std::error_code ignored;
        const bool deep = options.images_dir || !fs::equivalent(folder, folder_of(scene.listing), ignored);
        index.emplace(folder, deep);
      }
      view.photo = index->match(scene.listing, stated[i]);
    }
  }
  std::map<fs::path, const View*> known;
  for (const View& view : scene.views) {
    if (view.photo.empty()) continue;
    const auto [first, fresh] = known.emplace(view.photo.lexically_normal(), &view);
    if (!fresh)
      throw InputError(scene.listing, "",
                       "the images '" + first->second->name + "' and '" + view.name +
                           "' are the same photo, " + view.photo.string());
  }
  return folder;
}

void fit_cameras(SceneFile& scene) {
  // Errors are collected so that the first view's is the one reported, whatever the threads did.
  std::vector<std::string> problem(scene.views.size());
  std::vector<ImageSize> sizes(scene.views.size());
  tbb::parallel_for(std::size_t{0}, scene.views.size(), [&](std::size_t i) {
    const View& view = scene.views[i];
    if (view.photo.empty()) return;
    try {
      sizes[i] = read_image_size(view.photo);
    } catch (const InputError& error) {
      problem[i] = error.what();
    }
  });
  std::size_t scaled = 0;
  std::string example;
  for (std::size_t i = 0; i < problem.size(); ++i) {
    View& view = scene.views[i];
    if (!problem[i].empty())
      throw InputError(view.photo, "", problem[i].substr(view.photo.string().size() + 2));
    if (view.photo.empty()) continue;
    const auto [width, height] = sizes[i];
    Camera& camera = view.camera;
    if (camera.width == 0) {
      scene.size_camera(camera, width, height);
      camera.width = width;
      camera.height = height;
      finish_camera(scene.listing, "image '" + view.name + "'", camera);
    } else if (width != camera.width || height != camera.height) {
      const std::string differs = "is " + size_text(width, height) + " pixels, its camera in " +
                                  folder_of(scene.listing).string() + " is calibrated for " +
                                  size_text(camera.width, camera.height);
      if (!same_shape(width, height, camera))
        throw InputError(view.photo, "",
                         differs + (same_shape(height, width, camera) ? ": it has been turned by a quarter"
                                                                      : ", which is of another shape"));
      if (scaled++ == 0) example = view.name + " " + differs;
      scale(camera, width, height);
    }
  }
  if (scaled > 0)
    scene.warnings.push_back("the cameras of " + std::to_string(scaled) +
                             " photos were scaled to the photos' size: " + example);
}

}  // namespace gpvc
