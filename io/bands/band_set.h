// What the photos of a scene hold, all of them alike.
#pragma once

#include <vector>

#include "io/scene_files.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// Fills SceneFile::bands and SceneFile::band_places from the views that need their photo, if these hold more than grey or RGB of 8 bits,
/// or lie in several files. Opens the headers of all others than JPEGs, and decodes up to eight photos of those with bands, from
/// the whole scene, for the range, for the places of bands in files of their own, and where TIFFs have an alpha. An alpha of
/// which, in the mean over these, less than half of the pixels above 0 are opaque (opaque_share) is a band, whatever the file calls it
/// (View::uses_alpha is taken back then), with a warning. Colours of different
/// depths remain what is looked at in 8 bits, with a warning. Throws InputError for photos that differ in type or number of
/// bands otherwise, for files of a photo of different size or type, and for a composite of bands that are not there.
/// \pre masks are found, cameras have the size of the photos
void find_bands(SceneFile& scene, const std::vector<bool>& needed, const SceneOptions& options);

}  // namespace gpvc::io
