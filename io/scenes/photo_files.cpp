#include "io/scenes/photo_files.h"

#include <tbb/parallel_for.h>
#include <utf8proc.h>

#include <algorithm>
#include <compare>
#include <cstdlib>
#include <map>
#include <memory>
#include <set>
#include <unordered_map>

#include "io/files/text_scan.h"
#include "io/images/image_file.h"
#include "io/near_words.h"
#include "io/scenes/bad_photos.h"
#include "io/scenes/layers.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

/// "a/b/../c" as {a, c}; leading "..", "/" and "C:" stay as parts of their own.
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  for (const fs::path& part : fs::path(path).lexically_normal())
    if (!part.empty() && part != ".") parts.push_back(part.string());
  return parts;
}

/// For comparing names: in small letters, and accents in one piece with their letters (Unicode's NFC; macOS takes them
/// apart).
std::string folded(const std::string& name) {
  std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> composed(
      utf8proc_NFC(reinterpret_cast<const utf8proc_uint8_t*>(name.c_str())), &std::free);
  return lower_case(composed ? reinterpret_cast<const char*>(composed.get()) : name.c_str());  // null: no UTF-8
}

bool is_drive(const std::string& part) { return part.size() == 2 && part[1] == ':'; }

/// True for a name that can be joined to a folder and can name outputs.
bool is_plain(const std::string& name) {
  const std::vector<std::string> parts = parts_of(name);
  return !parts.empty() && name.front() != '/' && !is_drive(parts.front()) && parts.front() != ".." &&
         name.find("/..") == std::string::npos;
}

/// The path with all links resolved; the path itself where that fails.
fs::path real_path(const fs::path& path) {
  std::error_code failed;
  const fs::path real = fs::canonical(path, failed);
  return failed ? path.lexically_normal() : real;
}

/// \pre both are real paths
bool lies_in(const fs::path& inner, const fs::path& outer) {
  const fs::path relative = inner.lexically_relative(outer);
  return !relative.empty() && *relative.begin() != "..";
}

bool has_extension(const fs::path& name, std::initializer_list<std::string_view> extensions) {
  return std::ranges::find(extensions, lower_case(name.extension().string())) != extensions.end();
}

/// Raw formats, which cameras write beside the photos that they develop themselves.
bool is_raw(const fs::path& name) {
  return has_extension(name, {".dng", ".arw", ".cr2", ".cr3", ".nef", ".orf", ".pef", ".raf", ".rw2"});
}

/// Number of path parts equal from the end: exactly, or ignoring case; `by_stem` ignores the file name's extension.
std::size_t common_tail(const std::vector<std::string>& a, const std::vector<std::string>& b, bool exact,
                        bool by_stem) {
  const auto same = [&](const std::string& x, const std::string& y) {
    return exact ? x == y : folded(x) == folded(y) || (by_stem && &x == &a.back());
  };
  const auto end = std::mismatch(a.rbegin(), a.rend(), b.rbegin(), b.rend(), same).first;
  return static_cast<std::size_t>(end - a.rbegin());
}

/// The files in and below a folder, by file name in small letters, and by that without extension.
class PhotoIndex {
 public:
  /// `deep`: with all folders below it, behind links too.
  PhotoIndex(const fs::path& folder, bool deep) : folder_(folder) {
    std::set<fs::path> links;
    if (deep) {
      add_below<fs::recursive_directory_iterator>(folder, links);
      follow(links);
    } else {
      add_below<fs::directory_iterator>(folder, links);
    }
  }

  void add(const fs::path& path) {
    if (!is_file(path)) return;
    const File file{path, parts_of(path.string())};
    by_name_[folded(path.filename().string())].push_back(file);
    if (has_image_extension(path)) by_stem_[folded(path.stem().string())].push_back(file);
  }

  /// The file whose path has the longest tail in common with `wanted`, `preferred` where several have; empty when none
  /// fits. Throws when several fit equally well.
  fs::path match(const fs::path& listing, const std::string& wanted, const fs::path& preferred) const {
    const std::vector<std::string> tail = parts_of(wanted);
    const std::string key = folded(tail.back());
    for (const bool exact : {true, false})
      if (const auto found = best(tail, by_name_, key, exact, false); !found.empty())
        return only(found, listing, wanted, preferred);
    auto found = best(tail, by_stem_, key, false, true);
    // OpenSfM names undistorted photos NAME.jpg.jpg. NAME.jpg.png would be a mask.
    if (has_image_extension(tail.back()))
      std::erase_if(found, [&](const fs::path& path) {
        return lower_case(path.extension().string()) != lower_case(fs::path(key).extension().string());
      });
    if (!std::all_of(found.begin(), found.end(), is_raw)) std::erase_if(found, is_raw);
    return found.empty() ? fs::path() : only(found, listing, wanted, preferred);
  }

  /// The name of a photo that is none of `taken` and differs from `wanted` as a slip of the pen does; empty: there is none.
  std::string near(const std::string& wanted, const std::set<fs::path>& taken) const {
    std::vector<std::string> names;
    for (const auto& [name, files] : by_name_)
      for (const File& file : files)
        if (has_image_extension(file.path) && !taken.contains(file.path)) names.push_back(file.parts.back());
    const std::string name = parts_of(wanted).back();
    const std::vector<std::string> nearest = near_words(name, names, 1, 1 + name.size() / 4);
    return nearest.empty() ? std::string() : nearest.front();
  }

 private:
  struct File {
    fs::path path;
    std::vector<std::string> parts;
  };
  using Index = std::unordered_map<std::string, std::vector<File>>;

  /// Files are added, links to folders collected.
  template <class Iterator>
  void add_below(const fs::path& folder, std::set<fs::path>& links) {
    std::error_code error, ignored;
    for (Iterator it(folder, fs::directory_options::skip_permission_denied, error); !error && it != Iterator();
         it.increment(error)) {
      if (it->is_symlink(ignored) && is_folder(it->path())) {
        links.insert(it->path());
      } else if (it->path().filename() == ".texture" || it->path().filename() == ".mask" ||
                 it->path().filename() == ".geometry") {
        // RealityCapture's layers have the names of their photos.
        if constexpr (requires { it.disable_recursion_pending(); }) it.disable_recursion_pending();
      } else {
        add(it->path());
      }
    }
  }

  /// Links to folders are followed in the order of their paths. A folder that several lead to is entered under each of
  /// their names, since names are what `match` goes by, but once under each, and by none that lies in it: that ends all
  /// loops.
  void follow(std::set<fs::path>& links) {
    std::set<std::pair<fs::path, fs::path>> entered;
    while (!links.empty()) {
      const fs::path link = links.extract(links.begin()).value(), target = real_path(link);
      if (lies_in(real_path(link.parent_path()), target)) continue;
      if (entered.emplace(target, link.filename()).second) add_below<fs::recursive_directory_iterator>(link, links);
    }
  }

  static std::vector<fs::path> best(const std::vector<std::string>& tail, const Index& index, const std::string& key,
                                    bool exact, bool by_stem) {
    const auto candidates = index.find(key);
    if (candidates == index.end()) return {};
    std::size_t longest = 0;
    std::vector<fs::path> found;
    for (const File& file : candidates->second) {
      const std::size_t common = common_tail(tail, file.parts, exact, by_stem);
      if (common == 0 || common < longest) continue;
      if (common > longest) found.clear();
      longest = common;
      found.push_back(file.path);
    }
    return found;
  }

  fs::path only(std::vector<fs::path> found, const fs::path& listing, const std::string& wanted,
                const fs::path& preferred) const {
    if (found.size() == 1) return found.front();
    if (std::find(found.begin(), found.end(), preferred) != found.end()) return preferred;
    std::sort(found.begin(), found.end());
    std::set<fs::path> files;
    std::erase_if(found, [&](const fs::path& path) { return !files.insert(real_path(path)).second; });
    if (found.size() == 1) return found.front();
    std::string names;
    for (std::size_t i = 0; i < found.size() && i < 5; ++i)
      names += (i == 0 ? "" : ", ") + found[i].lexically_relative(folder_).string();
    throw InputError(listing, "",
                     "the photo '" + wanted + "' could be any of " + std::to_string(found.size()) + " files in " +
                         folder_.string() + ": " + names + (found.size() > 5 ? ", ..." : ""));
  }

  fs::path folder_;
  Index by_name_, by_stem_;
};

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
  if (existing.empty())
    throw InputError(scene.listing, "", "the folder of the photos was not found; looked for " + looked);
  return existing;
}

/// A photo at another size than its camera's: the same picture when one factor explains both sides, whichever way they
/// were rounded. An equal side rounds nothing and allows no other.
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

/// Paths without their common folders and without parts that lead out of a folder; empty where nothing is left.
std::vector<std::string> below_shared_folder(const std::vector<std::vector<std::string>>& paths, bool with_drives) {
  std::size_t shared = paths.front().empty() ? 0 : paths.front().size() - 1;
  for (const auto& path : paths) {
    std::size_t same = 0;
    while (same < shared && same + 1 < path.size() && path[same] == paths.front()[same]) ++same;
    shared = same;
  }
  std::vector<std::string> below;
  for (const auto& path : paths) {
    std::string joined;
    for (std::size_t p = shared; p < path.size(); ++p) {
      if (path[p] == ".." || path[p] == "/" || (is_drive(path[p]) && !with_drives)) continue;
      joined += (joined.empty() ? "" : "/") + (is_drive(path[p]) ? path[p].substr(0, 1) : path[p]);
    }
    below.push_back(joined);
  }
  return below;
}

bool repeated(std::vector<std::string> names) {
  std::ranges::sort(names);
  return std::ranges::adjacent_find(names) != names.end();
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

}  // namespace

bool has_image_extension(const fs::path& name) {
  return is_raw(name) || has_extension(name, {".jpg",  ".jpeg", ".jpe",  ".png",  ".tif", ".tiff", ".exr",
                                              ".webp", ".bmp",  ".jp2",  ".j2k",  ".pgm", ".ppm",  ".pnm",
                                              ".hdr",  ".heic", ".heif", ".avif", ".psd", ".dpx",  ".tga"});
}

void normalize_names(SceneFile& scene) {
  if (!std::ranges::all_of(scene.views, is_plain, &View::name)) {
    std::vector<std::vector<std::string>> names;
    for (const View& view : scene.views) names.push_back(parts_of(view.name));
    // Drive letters distinguish photos only where their folders do not.
    std::vector<std::string> below = below_shared_folder(names, false);
    if (repeated(below)) below = below_shared_folder(names, true);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (below[i].empty())
        throw InputError(scene.listing, "", "the image '" + scene.views[i].name + "' has no file name");
      View& view = scene.views[i];
      if (view.photo.empty() && (names[i].front() == "/" || is_drive(names[i].front()))) view.photo = view.name;
      view.name = below[i];
    }
  }
  std::ranges::sort(scene.views, {}, &View::name);
  const auto twice = std::ranges::adjacent_find(scene.views, {}, &View::name);
  if (twice != scene.views.end()) throw InputError(scene.listing, "", "lists the image '" + twice->name + "' twice");
}

namespace {

/// Notes needed photos that are not there, with the file that may be meant.
void note_missing(SceneFile& scene, const std::vector<bool>& needed, const std::vector<std::string>& stated,
                  const PhotoIndex* index) {
  std::set<fs::path> taken;
  for (const View& view : scene.views) taken.insert(view.photo);
  const auto noted = [&](const View& view) {
    return std::ranges::find(scene.bad_photos, view.name, &BadPhoto::view) != scene.bad_photos.end();
  };
  constexpr std::size_t kMostSearched = 20;  // each of them takes a look at all files
  std::size_t searched = 0;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    if (!needed[i] || !scene.views[i].photo.empty() || noted(scene.views[i])) continue;
    const std::string near = index && ++searched <= kMostSearched ? index->near(stated[i], taken) : std::string();
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
  if (!options.allow_missing_photos) note_missing(scene, needed, stated, index ? &*index : nullptr);
  return folder;
}

std::vector<std::exception_ptr> for_each_photo(std::span<const View> views,
                                               const std::function<void(std::size_t)>& work) {
  std::vector<std::exception_ptr> errors(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    try {
      if (!views[i].photo.empty()) work(i);
    } catch (const InputError&) {
      errors[i] = std::current_exception();
    }
  });
  return errors;
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

void fit_cameras(SceneFile& scene, const std::vector<bool>& needed) {
  std::vector<ImageSize> sizes(scene.views.size());
  const std::vector<std::exception_ptr> errors =
      for_each_photo(scene.views, [&](std::size_t i) { sizes[i] = read_image_size(scene.views[i].photo); });
  std::size_t scaled = 0;
  std::string example;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    View& view = scene.views[i];
    if (errors[i]) try {
        std::rethrow_exception(errors[i]);
      } catch (const InputError& error) {
        forget_photo(scene, i, needed[i], BadPhoto::Problem::unreadable, reason_of(error, view.photo));
      }
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
      if (!same_shape(width, height, camera)) {
        const bool turned = same_shape(height, width, camera);
        forget_photo(scene, i, needed[i], turned ? BadPhoto::Problem::turned : BadPhoto::Problem::other_shape, differs);
        continue;
      }
      if (scaled++ == 0) example = view.name + " " + differs;
      scale(camera, width, height);
    }
  }
  if (scaled > 0)
    scene.warnings.push_back("the cameras of " + std::to_string(scaled) +
                             " photos were scaled to the photos' size: " + example);
}

}  // namespace gpvc::io
