#include "io/images/mask_file.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <exception>

#include "io/files/text_scan.h"
#include "io/images/image_file.h"
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
  for (const fs::path& candidate : candidates) {
    std::error_code ignored;
    if (fs::is_regular_file(candidate, ignored)) return candidate;
  }
  return {};
}

/// False for JPEG, which has no alpha: saves opening every photo of a flight.
bool may_have_alpha(const fs::path& photo) {
  const std::string extension = lower_case(photo.extension().string());
  return extension != ".jpg" && extension != ".jpeg";
}

/// Sets the bits of the pixels that are marked.
void mark(const std::vector<std::uint8_t>& marked, PhotoExclusion& exclusion) {
  const auto width = static_cast<std::size_t>(exclusion.width);
  for (std::size_t i = 0; i < marked.size(); ++i)
    if (marked[i] != 0)
      exclusion.words[i / width * exclusion.stride + i % width / 64] |= std::uint64_t{1} << (i % width % 64);
}

PhotoExclusion empty_exclusion(int width, int height) {
  PhotoExclusion exclusion;
  exclusion.width = width;
  exclusion.height = height;
  exclusion.stride = (static_cast<std::size_t>(width) + 63) / 64;
  exclusion.words.assign(exclusion.stride * static_cast<std::size_t>(height), 0);
  return exclusion;
}

bool any(const PhotoExclusion& exclusion) {
  return std::any_of(exclusion.words.begin(), exclusion.words.end(), [](std::uint64_t w) { return w != 0; });
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
  std::error_code ignored;
  if (options.masks_dir && !fs::is_directory(*options.masks_dir, ignored))
    throw InputError(*options.masks_dir, "", "is not a folder; it was given as the folder of the masks");
  // Errors are collected so that the first view's is reported, for any number of threads.
  std::vector<std::exception_ptr> problems(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    View& view = views[i];
    if (view.photo.empty()) return;
    try {
      view.mask = mask_of(scene.listing, view, options);
      view.uses_alpha = may_have_alpha(view.photo) && has_alpha(view.photo);
      if (view.mask.empty()) return;
      const ImageSize size = read_image_size(view.mask);
      if (size.width != view.camera.width || size.height != view.camera.height)
        throw InputError(view.mask, "",
                         "is " + size_text(size.width, size.height) + " pixels, its photo " +
                             view.photo.filename().string() + " is " +
                             size_text(view.camera.width, view.camera.height));
    } catch (const InputError&) {
      problems[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& problem : problems)
    if (problem) std::rethrow_exception(problem);
  std::size_t missing = 0;
  const fs::path* first = nullptr;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!stated[i].empty() && views[i].mask.empty()) {
      ++missing;
      if (first == nullptr) first = &stated[i];
    }
  if (missing > 0)
    scene.warnings.push_back(std::to_string(missing) + " masks that the scene names are not found, among them " +
                             first->string());
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
    const PixelMarks marks = alpha ? transparent_pixels(file) : black_pixels(file);
    if (marks.width / view.reduction != view.camera.width || marks.height / view.reduction != view.camera.height ||
        (exclusion && (exclusion->width != marks.width || exclusion->height != marks.height)))
      throw InputError(file, "",
                       "is " + size_text(marks.width, marks.height) + " pixels, which does not fit its camera");
    if (!exclusion) exclusion = empty_exclusion(marks.width, marks.height);
    mark(marks.marked, *exclusion);
  }
  if (!any(*exclusion)) return std::nullopt;
  return exclusion;
}

PhotoExclusion reduce_exclusion(const PhotoExclusion& exclusion, int factor) {
  if (factor == 1) return exclusion;
  const int width = exclusion.width / factor, height = exclusion.height / factor;
  PhotoExclusion out = empty_exclusion(width, height);
  for (int y = 0; y < height * factor; ++y)
    for (int x = 0; x < width * factor; ++x)
      if (exclusion.excludes(x, y)) {
        const auto column = static_cast<std::size_t>(x / factor);
        out.words[static_cast<std::size_t>(y / factor) * out.stride + column / 64] |= std::uint64_t{1} << (column % 64);
      }
  return out;
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
  if (exclusion && view.reduction > 1) exclusion = reduce_exclusion(*exclusion, view.reduction);
  return exclusion;
}

}  // namespace gpvc::io
