// Parts of reading masks that only io/ needs.
#pragma once

#include <optional>
#include <vector>

#include "io/photos.h"
#include "io/scene_files.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// Fills View::mask and View::uses_alpha of views whose photos are known and whose cameras are at full size. A mask
/// that the scene's file states is looked for at that path (a relative one starts at the file's folder) and by its name
/// beside the photo, or, if a folder of masks is given, only there; then under the names that read_exclusion lists.
/// Warns of stated masks that are not found. No photo of the scene is a mask. Throws InputError for a mask of another
/// size than its photo, for a given folder without a single mask, and for a mask in it that was found by its name alone for
/// photos in several folders.
void find_masks(SceneFile& scene, const SceneOptions& options);

/// read_exclusion before the reduction, and of a panorama as its file shows it. \pre camera size times View::reduction
/// is at most the photo's \param transparent what transparent_pixels() gives; nullopt: not known
std::optional<PhotoExclusion> read_whole_exclusion(const View& view, std::optional<PhotoExclusion> transparent = {});

/// What is then done with it.
std::optional<PhotoExclusion> fit_to_view(std::optional<PhotoExclusion> whole, const View& view);

/// As for an image, in io/images.h.
PhotoExclusion continue_around(const PhotoExclusion& panorama);

/// Gives excluded pixels the colours of their surroundings (see fill_holes), so that no filter mixes them in.
/// O(pixels).
void paint_over(Image& image, const PhotoExclusion& exclusion);
void paint_over(Samples& samples, const PhotoExclusion& exclusion);

}  // namespace gpvc::io
