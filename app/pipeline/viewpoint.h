// The up axis of a scene, a camera for a picture of the result, and a local origin.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "../../io/scene.h"
#include "../../io/textured_model.h"

namespace gpvc::pipeline {

/// Where "up" is: opposite to the cameras' mean viewing direction, or, for photos taken on the ground (up directions agree,
/// viewing directions are level), the mean of the cameras' own up directions. Of length 1. \pre a used view
WorldPoint up_direction(const Scene& scene, std::span<const ViewId> used);

/// The axis of the scene that is nearest to up_direction().
io::UpAxis scene_up(const Scene& scene, std::span<const ViewId> used);

WorldPoint up_vector(io::UpAxis axis);

struct Viewpoint {
  Camera camera;
  Pose pose;
};

/// A camera of `width` x `height` pixels that frames the faces with a view, from the side that the cameras see; at most 40
/// degrees below the horizon. Outliers, up to one corner in five hundred on each side, are ignored.
Viewpoint overview(const Mesh& mesh, std::span<const ViewId> labels, const Scene& scene, std::span<const ViewId> used,
                   io::UpAxis up, int width, int height);

/// An origin to subtract from the positions that are written so that floats hold them. Zero if the rounding error is below a hundredth of the
/// median ground sampling distance. Otherwise the middle of the faces with a view, rounded to a power of ten below their
/// extent (at most 100). Outliers are ignored as in overview().
WorldPoint local_origin(const Mesh& mesh, const std::vector<WorldPoint>& written, std::span<const ViewId> labels,
                        const Scene& scene, std::span<const ViewId> used);

/// What was chosen for the files of a model.
struct WrittenModel {
  Viewpoint preview;  ///< of preview.png
  std::array<std::uint8_t, 3> background{};
  io::UpAxis up{};
  WorldPoint offset;  ///< to be added to the model's coordinates
};

}  // namespace gpvc::pipeline
