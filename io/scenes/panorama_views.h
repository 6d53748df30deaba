// Equirectangular photos as the views that the stages work with.
#pragma once

#include <vector>

#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// The camera of a photo that shows all directions: 2 pi across the whole width, the way it looks in the middle, and `down`
/// pixels a radian of latitude. Readers may move its principal point by part of a pixel. They hand over one view of it for
/// each such photo, and read_scene() makes six of it.
Camera panorama_camera(int width, int height, double down);

/// True if the view is a whole panorama's, as readers hand it over.
bool is_panorama(const View& view);

/// The six views of a panorama of the size that the stages work in, or the view itself if it is none. The photo DIR/STEM.EXT
/// becomes the views DIR/STEM/front.EXT, right, back, left, up and down: the way the camera looks is front.
std::vector<View> views_of(const View& view);

}  // namespace gpvc::io
