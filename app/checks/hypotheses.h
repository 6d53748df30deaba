// Explains a scene whose photos, poses and mesh do not fit together.
#pragma once

#include <span>
#include <string>

#include "app/checks/input.h"
#include "app/checks/mesh_fit.h"

namespace gpvc::checks {

/// measure_fit() at faces inside the frames of photos, whether the photos see them or something hides them: for scenes whose few
/// views hardly ever see a face from similar directions. Hidden faces make it less reliable than places that views see. O(views).
MeshFit framed_fit(const Input& input, std::span<const SmallPhoto> photos);

/// Tries common mistakes: photos in another order or upside down, exchanged or mirrored axes, inverse poses, another unit,
/// another lens, photos of another size. Returns a clause about the one with which the photos agree on the mesh, such as
/// "with the poses inverted they would agree on the mesh at 610 places instead of 20"; empty if none is `clearly` times as
/// good as the scene is. Some seconds.
std::string fitting_hypothesis(const Input& input, std::span<const SmallPhoto> photos, results::Observer& observer,
                               double clearly = 2);

}  // namespace gpvc::checks
