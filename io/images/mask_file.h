// Parts of reading masks that only io/ needs.
#pragma once

#include <optional>
#include <vector>

#include "io/photos.h"
#include "io/scene_files.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// Fills View::mask and View::uses_alpha of views whose photos are known and whose cameras are at full size. A
/// View::mask that the scene's file states is looked for there, a relative one from that file's folder, and by its name
/// beside the photo, in a given folder of masks only there; then as read_exclusion says. Warns of stated masks that are
/// not found. Throws InputError for a mask of another size than its photo, and for a given folder without a single
/// mask.
void find_masks(SceneFile& scene, const SceneOptions& options);

/// read_exclusion before the reduction. \pre camera size times View::reduction is at most the photo's
std::optional<PhotoExclusion> read_whole_exclusion(const View& view);

/// Every `factor` x `factor` block, as reduce_image cuts them: excluded when one of its pixels is.
PhotoExclusion reduce_exclusion(const PhotoExclusion& exclusion, int factor);

/// Gives excluded pixels the colours of their surroundings, ever coarser means of what is left, so that no filter picks
/// up what was there. O(pixels).
void paint_over(Image& image, const PhotoExclusion& exclusion);

}  // namespace gpvc::io
