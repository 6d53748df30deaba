// Equirectangular photos as the views that the stages work with.
#pragma once

#include <vector>

#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// The camera of a photo that shows all directions: 2 pi across the whole width, and `down` pixels a radian of latitude. The
/// way it looks is `off` its middle, which some programs have half a pixel elsewhere. Readers hand over one view of it for
/// each such photo, and read_scene() makes six of it. Throws InputError at `place` where `off` is beyond a pixel across, and
/// as finish_camera() does.
Camera panorama_camera(const std::filesystem::path& file, const std::string& place, int width, int height, double down,
                       const PhotoPoint& off = {0, 0});

/// True if the view is a whole panorama's, as readers hand it over.
bool is_panorama(const View& view);

/// The six views of a panorama of the size that the stages work in, or the view itself if it is none. The photo DIR/STEM.EXT
/// becomes the views DIR/STEM/front.EXT, right, back, left, up and down: the way the camera looks is front.
std::vector<View> views_of(const View& view);

}  // namespace gpvc::io
