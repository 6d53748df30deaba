#include "io/images/mask_file.h"

#include <algorithm>

#include "io/files/text_scan.h"
#include "io/images/image_file.h"
#include "io/lens/spherical.h"
#include "io/push_pull.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

/// The first file that exists of: the mask that the scene's file states (a relative path starts at that file's folder,
/// never at the current one); masks beside the photo; or, in a given folder of masks, those named after the view, with
/// COLMAP's spelling last.
fs::path mask_of(const fs::path& listing, const View& view, const SceneOptions& options) {
  std::vector<fs::path> stems, candidates;
  if (options.masks_dir)
    stems = {*options.masks_dir / view.name, *options.masks_dir / view.photo.filename()};
  else
    stems = {view.photo};
  if (!view.mask.empty() && options.masks_dir)
    candidates = {*options.masks_dir / view.mask.filename()};
  else if (!view.mask.empty())
    candidates = {folder_of(listing) / view.mask, view.photo.parent_path() / view.mask.filename()};
  for (const fs::path& stem : stems) {
    candidates.push_back(stem.string() + ".mask.png");
    candidates.push_back((stem.parent_path() / stem.stem()).string() + ".mask.png");
    if (options.masks_dir) candidates.push_back(stem.string() + ".png");
  }
  const auto found = std::find_if(candidates.begin(), candidates.end(), is_file);
  return found == candidates.end() ? fs::path() : *found;
}

/// False for JPEG, which has no alpha: saves opening every photo of a flight.
bool may_have_alpha(const fs::path& photo) {
  const std::string extension = lower_case(photo.extension().string());
  return extension != ".jpg" && extension != ".jpeg";
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
  const std::vector<std::exception_ptr> errors = for_each_photo(views, [&](std::size_t i) {
    View& view = views[i];
    view.mask = mask_of(scene.listing, view, options);
    view.uses_alpha = may_have_alpha(view.photo) && has_alpha(view.photo);
    if (view.mask.empty()) return;
    const ImageSize size = read_image_size(view.mask);
    if (size.width != view.camera.width || size.height != view.camera.height)
      throw InputError(view.mask, "",
                       "is " + size_text(size.width, size.height) + " pixels, its photo " +
                           view.photo.filename().string() + " is " + size_text(view.camera.width, view.camera.height));
  });
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
  std::size_t missing = 0;
  fs::path first;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!stated[i].empty() && views[i].mask.empty() && missing++ == 0) first = stated[i];
  scene.warn(missing, "masks that the scene names are not found, among them " + first.string());
  if (options.masks_dir && !views.empty() &&
      std::all_of(views.begin(), views.end(), [](const View& view) { return view.mask.empty(); }))
    throw InputError(*options.masks_dir, "",
                     "holds no mask of any photo; expected names like " + views.front().name + ".mask.png");
}

std::optional<PhotoExclusion> read_whole_exclusion(const View& view) {
  if (view.mask.empty() && !view.uses_alpha) return std::nullopt;
  std::optional<PhotoExclusion> exclusion;
  for (const bool alpha : {false, true}) {
    if (alpha ? !view.uses_alpha : view.mask.empty()) continue;
    const fs::path& file = alpha ? view.photo : view.mask;
    PhotoExclusion zeros = zero_pixels(file, alpha);
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

void paint_over(Image& image, const PhotoExclusion& exclusion) {
  std::vector<std::uint8_t> known;
  known.reserve(image.pixels.size() / 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) known.push_back(exclusion.excludes(x, y) ? 0 : 1);
  fill_holes(image, known, false);
}

bool has_plain_mask(const View& view) {
  constexpr std::string_view kPng = "\x89PNG\r\n\x1A\n";
  return !view.mask.empty() && !view.uses_alpha && first_bytes(view.mask, kPng.size()) == kPng && !has_alpha(view.mask);
}

std::optional<PhotoExclusion> read_exclusion(const View& view) {
  std::optional<PhotoExclusion> exclusion = read_whole_exclusion(view);
  if (exclusion && view.reduction > 1) exclusion = reduced(*exclusion, view.reduction);
  if (exclusion && is_spherical(view.camera.distortion.model)) exclusion = continue_around(*exclusion);
  return exclusion;
}

}  // namespace gpvc::io
