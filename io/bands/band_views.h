// Bands that a scene has views of their own for.
#pragma once

#include <vector>

#include "io/scene_files.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// Where most views that need their photo are files of a photo's bands (band_file_name), takes those of all bands but one out of the
/// scene, and gives what is left of each photo View::band_files and, unless all bands have its own camera and pose, as OpenDroneMap
/// copies them, View::band_cameras. The one that is left is the band with the most views, the first of several. Where the scene lacks
/// a band's camera and the file is there, it is that of the first photo with all of them, moved along; a photo without a file of a band
/// is forgotten (forget_photo), bands without the photo are left out with a warning, and so are bands of another size or type. Where
/// cameras of one photo's bands lie a fifth as far apart as those of different photos, all stay views of their own, with a warning.
/// \pre cameras have the size of the photos; `needed`: per view, is cut like the views
void join_band_views(SceneFile& scene, std::vector<bool>& needed, const SceneOptions& options);

}  // namespace gpvc::io
