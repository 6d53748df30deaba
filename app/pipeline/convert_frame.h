// Frames of undistorted photos, and their masks.
#pragma once

#include "app/cli/options.h"
#include "app/evaluate/rephotography.h"

namespace gpvc::pipeline {

/// The pixels of a camera's frame that its undistorted photo gets. `inside` and `all` reach beyond the photo's own size
/// where the lens is a barrel, on each side by half of it at most. A lens of which `inside` would leave less than a
/// fifth of the width or the height (it folds, or sees too far aside) keeps its size. The photo's size where there is
/// no distortion. O(width + height).
evaluate::FrameWindow frame_window(const Camera& camera, cli::FrameRule rule);

/// Whether some pixel of the window shows nothing of the photo. O(width + height).
bool shows_blank(const Camera& camera, const evaluate::FrameWindow& window);

/// The camera of the undistorted photo in this window.
Camera framed(const Camera& camera, const evaluate::FrameWindow& window);

/// The mask of the undistorted photo: one channel, 255 for what may be used, 0 where the window shows nothing of the
/// photo or where any of the four pixels that undistort_photo mixes is excluded, so that no colour of an excluded pixel
/// is left. `exclusion` may be null.
Image undistort_mask(const io::PhotoExclusion* exclusion, const Camera& camera, const evaluate::FrameWindow& window);

/// An exclusion as it is, likewise.
Image mask_image(const io::PhotoExclusion& exclusion);

}  // namespace gpvc::pipeline
