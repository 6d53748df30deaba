#include "app/evaluate/shown_photos.h"

#include <cmath>

namespace gpvc::evaluate {
namespace {

/// Id pictures kept in memory: decoding one takes a tenth of a second for 6 megapixels, and every model needs them all.
constexpr std::size_t kKeptBytes = std::size_t{1} << 30;

}  // namespace

std::optional<PhotoPoint> ShownPhoto::project(const WorldPoint& p) const {
  const auto at = photo_from_world(view, p);
  if (!at || !(at->x >= 0) || !(at->y >= 0) || at->x >= photo->width || at->y >= photo->height) return std::nullopt;
  return at;
}

Pixel ShownPhoto::color(int x, int y) const {
  const double dx = (x + 0.5) / photo->width * 2 - 1, dy = (y + 0.5) / photo->height * 2 - 1;
  // The synthetic camera's vignetting grows with the squared distance in pixels, which is 1 in the corners.
  const double w = photo->width, h = photo->height;
  const double corner_share = (dx * dx * w * w + dy * dy * h * h) / (w * w + h * h);
  const std::uint8_t* p = photo->at(x, y);
  Pixel color{};
  for (std::size_t c = 0; c < 3; ++c)
    color[c] = static_cast<float>(1 / exposure.at(c, corner_share)) * static_cast<float>(p[c]);
  return color;
}

ShownPhoto::Window ShownPhoto::window(const PhotoPoint& at, std::uint32_t of) const {
  const int x0 = static_cast<int>(std::floor(at.x - 0.5)) - 1, y0 = static_cast<int>(std::floor(at.y - 0.5)) - 1;
  Window found;
  for (int y = y0; y < y0 + 4; ++y)
    for (int x = x0; x < x0 + 4; ++x) {
      const bool in_photo = x >= 0 && y >= 0 && x < photo->width && y < photo->height;
      const std::uint32_t shows = in_photo ? surface(x, y) : synth::kNoSurface;
      if (shows != of) found.alone = false;
      if (shows == of || shows == synth::kMixedSurfaces) found.any = true;
    }
  return found;
}

ShownPhoto ShownPhotos::photo(ViewId id) const {
  const View& view = scene_.views[index(id)];
  const auto exposure = truth_.exposures.find(view.name);
  return {view, photos_.photo(id), surfaces(id),
          exposure == truth_.exposures.end() ? synth::Exposure{} : exposure->second};
}

IdPicture ShownPhotos::surfaces(ViewId id) const {
  if (const auto found = pictures_.find(id); found != pictures_.end()) return found->second;
  const View& view = scene_.views[index(id)];
  const int width = view.camera.width, height = view.camera.height;
  std::vector<std::uint32_t> shown = read_id_picture(truth_, view.name, width, height);
  if (const std::optional<io::PhotoExclusion> exclusion = io::read_exclusion(view)) {
    std::size_t pixel = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x, ++pixel)
        if (exclusion->excludes(x, y)) shown[pixel] = synth::kMixedSurfaces;
  }
  auto picture = std::make_shared<const std::vector<std::uint32_t>>(std::move(shown));
  const std::size_t bytes = picture->size() * sizeof(std::uint32_t);
  if (kept_bytes_ + bytes > kKeptBytes) return picture;
  kept_bytes_ += bytes;
  return pictures_[id] = std::move(picture);
}

}  // namespace gpvc::evaluate
