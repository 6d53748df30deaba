// A picture of how a render compares with a photo.
#pragma once

#include <string>

#include "app/evaluate/rephotography.h"
#include "io/image.h"

namespace gpvc::evaluate {

/// Photo, render and error side by side, each under two lines that say what it is. Pictures too narrow for these are
/// enlarged by a whole factor. `reduction`: what the photo has been reduced by. O(pixels).
Image score_picture(const std::string& view, const Rephotography& compared, int reduction);

}  // namespace gpvc::evaluate
