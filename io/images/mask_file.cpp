#include "io/images/mask_file.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "io/files/text_scan.h"
#include "io/images/image_file.h"
#include "io/lens/spherical.h"
#include "io/push_pull.h"
#include "io/scenes/layers.h"

namespace gpvc::io {
namespace {

/// Where a mask may lie beside its photo, or in a given folder of masks, under names made of `stem`: NAME.EXT.mask.png,
/// NAME.mask.png, NAME_mask.png (OpenDroneMap's and Metashape's); in a folder of its own also NAME.EXT.png (COLMAP's),
/// NAME.EXT itself and NAME.png. Others than PNGs as well.
std::vector<fs::path> named_after(const fs::path& stem, bool own_folder) {
  const std::string whole = stem.string(), bare = (stem.parent_path() / stem.stem()).string();
  std::vector<fs::path> names;
  for (const std::string& start :
       {whole + ".mask", bare + ".mask", bare + "_mask", own_folder ? whole : "", own_folder ? bare : ""}) {
    if (own_folder && start == bare) names.push_back(stem);
    for (const char* ending : layer_endings())
      if (!start.empty()) names.push_back(start + ending);
  }
  return names;
}

/// The photo that a view was made of, beside which its mask lies.
const fs::path& photo_of(const SceneFile& scene, const View& view) {
  const auto layer = scene.photos_of_layers.find(view.photo);
  return layer == scene.photos_of_layers.end() ? view.photo : layer->second;
}

/// The photos of a scene by their names in small letters, as a folder of masks may be that of the photos, and X_mask.jpg a
/// photo.
class PhotoNames {
 public:
  explicit PhotoNames(const SceneFile& scene) {
    for (const View& view : scene.views)
      if (!view.photo.empty()) photos_.emplace(name_of(photo_of(scene, view)), photo_of(scene, view));
  }
  bool has(const fs::path& file) const {
    const auto [begin, end] = photos_.equal_range(name_of(file));
    return std::any_of(begin, end, [&](const auto& photo) {
      std::error_code ignored;
      return fs::equivalent(file, photo.second, ignored);
    });
  }

 private:
  static std::string name_of(const fs::path& file) { return lower_case(file.filename().string()); }

  std::multimap<std::string, fs::path> photos_;
};

/// The mask of a photo in OpenDroneMap's folders: undistorted/masks/NAME.EXT.png of undistorted/images/NAME.EXT. Empty where there is
/// none, or one of another size, which is warned of: the folder may be about other photos.
fs::path odm_mask(SceneFile& scene, const View& view, FolderNames& names) {
  const fs::path& photo = photo_of(scene, view);
  const fs::path found = names.find(folder_of(photo) / ".." / "masks" / (photo.filename().string() + ".png"));
  if (found.empty()) return {};
  const ImageSize size = read_image_size(found);
  if (size.width == view.camera.width && size.height == view.camera.height) return found;
  scene.warnings.push_back(found.string() + " is " + size_text(size.width, size.height) + " pixels, its photo is " +
                           size_text(view.camera.width, view.camera.height) + ": it is not used as a mask");
  return {};
}

/// The first file that exists of: the mask that the scene's file states (a relative path starts at that file's folder,
/// never at the current one); masks beside the photo, RealityCapture's among them, and OpenDroneMap's; or, in a given folder of
/// masks, those named after the view or the photo.
fs::path mask_of(SceneFile& scene, const View& view, const SceneOptions& options, const PhotoNames& photos,
                 FolderNames& names) {
  const fs::path& photo = photo_of(scene, view);
  std::vector<fs::path> candidates;
  const auto add = [&](const std::vector<fs::path>& more) {
    candidates.insert(candidates.end(), more.begin(), more.end());
  };
  if (options.masks_dir) {
    if (!view.mask.empty()) candidates = {*options.masks_dir / view.mask.filename()};
    add(named_after(*options.masks_dir / view.name, true));
    add(named_after(*options.masks_dir / photo.filename(), true));
  } else {
    if (!view.mask.empty())
      candidates = {folder_of(scene.listing) / view.mask, photo.parent_path() / view.mask.filename()};
    add(named_after(photo, false));
    candidates.push_back(photo.string() + ".msk");  // GDAL's
  }
  for (const fs::path& candidate : candidates)
    if (const fs::path found = names.find(candidate); !found.empty() && !photos.has(found)) return found;
  if (options.masks_dir) return {};
  const fs::path layer = names.find_layer(photo, "mask");
  return layer.empty() ? odm_mask(scene, view, names) : layer;
}

/// Refuses a mask in a given folder that lies there for photos of one name in several folders. \param stated the masks that
/// the scene states for its views: one of them may be that of many photos
void refuse_shared_masks(const SceneFile& scene, std::span<const fs::path> stated) {
  struct Owner {
    fs::path of;  ///< the mask that the scene states, or else the folder of the photo
    const View* view;
  };
  std::map<fs::path, Owner> owners;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const View& view = scene.views[i];
    if (view.mask.empty()) continue;
    const bool is_stated = lower_case(view.mask.filename().string()) == lower_case(stated[i].filename().string());
    const fs::path of = is_stated ? stated[i] : photo_of(scene, view).parent_path();
    const Owner& first = owners.try_emplace(view.mask, Owner{of, &view}).first->second;
    if (first.of != of && photo_of(scene, *first.view) != photo_of(scene, view))
      throw InputError(view.mask, "",
                       "could be the mask of " + quote(first.view->name) + " or of " + quote(view.name) +
                           ": expected masks in folders like the photos'");
  }
}

/// What a folder holds instead of masks: the end of a sentence.
std::string held_instead(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  const auto options = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator at(folder, options, error), end; !error && at != end; at.increment(error))
    if (is_file(at->path())) names.push_back(at->path().lexically_relative(folder).string());
  std::ranges::sort(names);
  return names.empty() ? ", it holds no file" : ", found " + names.front() + (names.size() > 1 ? " and the like" : "");
}

/// Warns of grey in masks, of which a few are decoded.
void warn_of_grey(SceneFile& scene) {
  std::vector<fs::path> masks;
  for (const View& view : scene.views)
    if (!view.mask.empty()) masks.push_back(view.mask);
  constexpr std::size_t kMost = 8;
  const std::size_t count = std::min(masks.size(), kMost);
  std::vector<double> grey(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    try {
      grey[i] = mask_pixels(masks[i * masks.size() / count]).grey_share;
    } catch (const InputError&) {
      // told where the mask is used
    }
  });
  const auto most = std::ranges::max_element(grey);
  if (most == grey.end() || *most == 0) return;
  const auto hundredths = static_cast<int>(std::lround(1e4 * *most));
  scene.warnings.push_back(
      "masks are not black and white alone (JPEG, or resampled): what is darker than half is excluded; up to " +
      (hundredths == 0 ? "0.01" : std::to_string(hundredths / 100) + "." + std::to_string(hundredths / 10 % 10)) +
      " % of a mask's pixels are grey");
}

/// False for JPEG, which has no alpha: saves reading the header of every photo of a flight. By its first bytes, as photos are read:
/// programs write WebP and PNG under the name of a JPEG.
bool may_have_alpha(const fs::path& photo) {
  constexpr std::string_view kJpeg = "\xFF\xD8\xFF";
  const std::string head = first_bytes(photo, kJpeg.size());
  return head.size() == kJpeg.size() && head != kJpeg;
}

/// Reduces in the blocks of reduce_image; a block is excluded when one of its pixels is.
PhotoExclusion reduced(const PhotoExclusion& exclusion, int factor) {
  PhotoExclusion out = empty_exclusion(exclusion.width / factor, exclusion.height / factor);
  for (int y = 0; y < out.height * factor; ++y)
    for (int x = 0; x < out.width * factor; ++x)
      if (exclusion.excludes(x, y))
        exclude(out, static_cast<std::size_t>(x / factor), static_cast<std::size_t>(y / factor));
  return out;
}

/// 0 for the excluded ones.
std::vector<std::uint8_t> known_pixels(const PhotoExclusion& exclusion) {
  std::vector<std::uint8_t> known;
  known.reserve(pixel_index(0, exclusion.height, exclusion.width));
  for (int y = 0; y < exclusion.height; ++y)
    for (int x = 0; x < exclusion.width; ++x) known.push_back(exclusion.excludes(x, y) ? 0 : 1);
  return known;
}

}  // namespace

void find_masks(SceneFile& scene, const SceneOptions& options) {
  std::vector<View>& views = scene.views;
  std::vector<fs::path> stated(views.size());
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!options.masks || views[i].photo.empty())
      views[i].mask.clear();
    else
      stated[i] = views[i].mask;
  if (!options.masks) return;
  if (options.masks_dir && !is_folder(*options.masks_dir))
    throw InputError(*options.masks_dir, "", "is not a folder; it was given as the folder of the masks");
  FolderNames names;
  const PhotoNames photos(scene);
  for (View& view : views)
    if (!view.photo.empty()) view.mask = mask_of(scene, view, options, photos, names);
  if (options.masks_dir) refuse_shared_masks(scene, stated);
  const std::vector<std::exception_ptr> errors = for_each_photo(views, [&](std::size_t i) {
    View& view = views[i];
    view.uses_alpha = may_have_alpha(view.photo) && hides_pixels(view.photo);
    for (const fs::path& file : view.band_files) view.uses_alpha = view.uses_alpha || hides_pixels(file);
    if (view.mask.empty()) return;
    const ImageSize size = read_image_size(view.mask);
    if (size.width != view.camera.width || size.height != view.camera.height)
      throw InputError(view.mask, "",
                       "is " + size_text(size.width, size.height) + " pixels, its photo " +
                           view.photo.filename().string() + " is " + size_text(view.camera.width, view.camera.height));
  });
  throw_together(errors, "masks cannot be used");
  std::size_t missing = 0;
  fs::path first;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!stated[i].empty() && views[i].mask.empty() && missing++ == 0) first = stated[i];
  scene.warn(missing, "masks that the scene names are not found, among them " + first.string());
  if (options.masks_dir && !views.empty() &&
      std::all_of(views.begin(), views.end(), [](const View& view) { return view.mask.empty(); }))
    throw InputError(*options.masks_dir, "",
                     "holds no mask of any photo; expected names like " + views.front().name + ".mask.png, " +
                         views.front().name + ".png or " + views.front().name + held_instead(*options.masks_dir));
  warn_of_grey(scene);
}

std::optional<PhotoExclusion> read_whole_exclusion(const View& view, std::optional<PhotoExclusion> transparent) {
  if (view.mask.empty() && !view.uses_alpha) return std::nullopt;
  std::optional<PhotoExclusion> exclusion;
  for (const bool alpha : {false, true}) {
    if (alpha ? !view.uses_alpha : view.mask.empty()) continue;
    const fs::path& file = alpha ? view.photo : view.mask;
    PhotoExclusion zeros = !alpha        ? mask_pixels(file).excluded
                           : transparent ? std::move(*transparent)
                                         : transparent_pixels(file);
    if (zeros.width / view.reduction != file_width(view.camera) ||
        zeros.height / view.reduction != view.camera.height ||
        (exclusion && (exclusion->width != zeros.width || exclusion->height != zeros.height)))
      throw InputError(file, "",
                       "is " + size_text(zeros.width, zeros.height) + " pixels, which does not fit its camera");
    for (std::size_t i = 0; exclusion && i < zeros.words.size(); ++i) zeros.words[i] |= exclusion->words[i];
    exclusion = std::move(zeros);
  }
  const auto& words = exclusion->words;
  if (std::all_of(words.begin(), words.end(), [](std::uint64_t word) { return word == 0; })) return std::nullopt;
  return exclusion;
}

void paint_over(Image& image, const PhotoExclusion& exclusion) { fill_holes(image, known_pixels(exclusion), false); }
void paint_over(Samples& samples, const PhotoExclusion& exclusion) { fill_holes(samples, known_pixels(exclusion)); }

bool has_plain_mask(const View& view) {
  constexpr std::string_view kPng = "\x89PNG\r\n\x1A\n";
  return !view.mask.empty() && !view.uses_alpha && first_bytes(view.mask, kPng.size()) == kPng &&
         !has_alpha(view.mask) && mask_pixels(view.mask).grey_share == 0;
}

std::optional<PhotoExclusion> fit_to_view(std::optional<PhotoExclusion> exclusion, const View& view) {
  if (exclusion && view.reduction > 1) exclusion = reduced(*exclusion, view.reduction);
  if (exclusion && is_spherical(view.camera.distortion.model)) exclusion = continue_around(*exclusion);
  return exclusion;
}

std::optional<PhotoExclusion> read_exclusion(const View& view) { return fit_to_view(read_whole_exclusion(view), view); }

}  // namespace gpvc::io
