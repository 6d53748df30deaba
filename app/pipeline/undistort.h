// Photos without their lens distortion, and the masks of such photos.
#pragma once

#include <cstdint>
#include <vector>

#include "../../io/names.h"
#include "../../io/photos.h"

namespace gpvc::pipeline {

/// How far an undistorted photo reaches; the focal length stays, the larger one of a centred window.
enum class FrameRule {
  inside,  ///< the largest rectangle in which the photo leaves nothing blank
  keep,    ///< the photo's own size
  all,     ///< every pixel of the photo
};
inline constexpr Named<FrameRule> kFrameRuleNames[] = {
    {"inside", FrameRule::inside}, {"keep", FrameRule::keep}, {"all", FrameRule::all}};

/// A rectangle of pixels of a camera's undistorted frame; it may reach beyond the frame's borders. x and y are those of
/// its first pixel. `centred`: for formats that state neither two focal lengths nor a principal point, a rectangle of square
/// pixels about the principal point instead, so that x and y are 0; their focal length is the larger of the camera's two,
/// so that no detail is lost.
struct FrameWindow {
  int x = 0, y = 0, width = 0, height = 0;
  bool centred = false;
  bool operator==(const FrameWindow&) const = default;
};

/// The window that a camera's undistorted photo covers; the photo's own size where there is no distortion. With a barrel
/// lens, `inside` and `all` reach beyond that size, by at most half of it on each side. Where `inside` would leave less
/// than a fifth of the width or height (the lens model folds, or its field of view is too wide), the photo keeps its
/// size. Of a panorama's view, whose frame is mostly blank, `keep` is `inside`: a square of 93 degrees. A centred window without distortion is chosen the same way; the bounds hold for it, too. O(width + height).
FrameWindow frame_window(const Camera& camera, FrameRule rule, bool centred = false);

/// Where the centre of pixel x, y of the window lies in the camera's frame.
PixelPoint frame_position(const Camera& camera, const FrameWindow& window, int x, int y);

/// True if some pixel of the window shows nothing of the photo. O(width + height).
bool shows_blank(const Camera& camera, const FrameWindow& window);

/// The camera of the undistorted photo in this window.
Camera camera_of_window(const Camera& camera, const FrameWindow& window);

/// The undistorted photo in a window, interpolated bilinearly. `inside` is set to 255 per pixel, 0 where the window shows
/// nothing of the photo.
Image undistort_photo(const Image& photo, const Camera& camera, const FrameWindow& window,
                      std::vector<std::uint8_t>& inside);

/// The mask of the undistorted photo: one channel, 255 for pixels that may be used. Pixels are 0 where the window shows
/// nothing of the photo, and where one of the four pixels that undistort_photo interpolates is excluded, so that no
/// excluded colour remains. `exclusion` may be null.
Image undistort_mask(const io::PhotoExclusion* exclusion, const Camera& camera, const FrameWindow& window);

/// An exclusion as a mask: one channel, 255 for pixels that may be used.
Image mask_image(const io::PhotoExclusion& exclusion);

}  // namespace gpvc::pipeline
