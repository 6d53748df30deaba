// Wide fisheyes as the views that the stages work with.
#pragma once

#include <vector>

#include "io/scene.h"

namespace gpvc::io {

/// The views that show a photo to its edge: the view alone, unless a third of the photo lies beyond its frame, as it does of
/// a fisheye of 100 degrees across (square) or 115 (3 : 2) and more. Then four more, DIR/STEM/right.EXT, left, down and up
/// for the photo DIR/STEM.EXT, of the same size and focal length, each turned so far that the edge of its frame passes through
/// the axis of the lens. O(1).
std::vector<View> fisheye_views(const View& view);

}  // namespace gpvc::io
