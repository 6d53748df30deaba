// A synthetic scene's photos, with the surface that each of their pixels shows.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "app/evaluate/truth.h"

namespace gpvc::evaluate {

using Pixel = std::array<float, 3>;
/// Per pixel of a photo a surface, kMixedSurfaces or kNoSurface.
using IdPicture = std::shared_ptr<const std::vector<std::uint32_t>>;

/// One photo and its id picture.
struct ShownPhoto {
  const View& view;
  std::shared_ptr<const Image> photo;
  IdPicture surfaces;
  synth::Exposure exposure;

  /// nullopt where the point lies outside the photo.
  std::optional<PhotoPoint> project(const WorldPoint& p) const;
  std::uint32_t surface(int x, int y) const { return (*surfaces)[pixel_index(x, y, photo->width)]; }
  /// The pixel's colour at an exposure of 1.
  Pixel color(int x, int y) const;
  /// Visits the photo's pixels within `reach` of `at` in x and y.
  template <class Visit>
  void around(const PhotoPoint& at, int reach, const Visit& visit) const {
    const int cx = static_cast<int>(at.x), cy = static_cast<int>(at.y);
    for (int y = std::max(0, cy - reach); y <= std::min(photo->height - 1, cy + reach); ++y)
      for (int x = std::max(0, cx - reach); x <= std::min(photo->width - 1, cx + reach); ++x) visit(x, y);
  }
  /// What the 4 x 4 pixels around a place show.
  struct Window {
    bool alone = true;  ///< all are in the photo and show the given surface alone
    bool any = false;   ///< one of them shows it, or several surfaces
  };
  Window window(const PhotoPoint& at, std::uint32_t surface) const;
};

/// The photos of a scene with their id pictures, read as they are asked for. Not for use by several threads at once.
class ShownPhotos {
 public:
  /// Borrows all.
  ShownPhotos(const Truth& truth, const Scene& scene, io::PhotoSource& photos)
      : truth_(truth), scene_(scene), photos_(photos) {}
  /// Throws InputError.
  ShownPhoto photo(ViewId id) const;
  /// Pixels that the view's mask excludes are kMixedSurfaces: they are used for nothing, so it does not matter what they
  /// show. Throws InputError.
  IdPicture surfaces(ViewId id) const;

 private:
  const Truth& truth_;
  const Scene& scene_;
  io::PhotoSource& photos_;
  mutable std::map<ViewId, IdPicture> pictures_;  ///< those kept in memory
  mutable std::size_t kept_bytes_ = 0;
};

}  // namespace gpvc::evaluate
