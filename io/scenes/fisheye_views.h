// Wide fisheyes as the views that the stages work with.
#pragma once

#include <vector>

#include "io/scene.h"

namespace gpvc::io {

/// The views that show a photo to its edge: the view alone, unless two fifths of the photo lie beyond its frame, as they do
/// of a fisheye of 105 degrees across (square) or 125 (3 : 2) and more. Then four more, DIR/STEM/right.EXT, left, down and up
/// for the photo DIR/STEM.EXT, of the same size and focal length, each turned so far that the edge of its frame passes through
/// the axis of the lens. O(1).
std::vector<View> fisheye_views(const View& view);

/// Finds how far from its axis each wide fisheye shows something, Distortion::max_angle: no file says how large its image
/// circle is, and what lies around it is dark. Decodes up to three photos of each such lens, needed or not, so that the
/// circle is that of the scene, and returns which. Forgets photos that are not needed and cannot be decoded; throws
/// InputError for others.
std::vector<HashedPhoto> find_image_circles(std::vector<View>& views, const std::vector<bool>& needed);

}  // namespace gpvc::io
