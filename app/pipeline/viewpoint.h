// Where up is, and where to look at a result from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "../../io/io.h"
#include "../../io/scene.h"

namespace gpvc::pipeline {

/// Away from the cameras' mean viewing direction, snapped to the nearest axis of the scene. Cameras that stand upright
/// on the ground have none of their up in that direction: when their own up directions agree and they look level by
/// them, the mean of those counts. \pre a used view
io::UpAxis scene_up(const Scene& scene, std::span<const ViewId> used);

WorldPoint up_vector(io::UpAxis axis);

struct Viewpoint {
  Camera camera;
  Pose pose;
};

/// A camera of `width` x `height` that frames what of the mesh has a view: from the cameras' side, at 40 degrees below
/// the horizon at most when they look down steeper. Faces far off the bulk (one corner in five hundred on each side) do
/// not count; of fewer corners all do.
Viewpoint overview(const Mesh& mesh, std::span<const ViewId> labels, const Scene& scene, std::span<const ViewId> used,
                   io::UpAxis up, int width, int height);

/// Subtracted from coordinates so that floats hold them: 0 while rounding stays below a hundredth of the median ground
/// sampling distance, else the middle of what of the mesh has a view, in whole multiples of a power of ten below its
/// extent (100 at most). Far stray corners do not count, as in overview().
WorldPoint local_origin(const Mesh& mesh, std::span<const ViewId> labels, const Scene& scene,
                        std::span<const ViewId> used);

}  // namespace gpvc::pipeline
