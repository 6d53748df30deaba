// What a textured result shows at a place.
#pragma once

#include <cstddef>
#include <filesystem>

#include "io/scene.h"

namespace gpvc::evaluate {

struct ShownPlace {
  std::size_t face = 0;   ///< of the input, the nearest to the place
  double distance = 0;    ///< of the place from it, in units of the mesh
  ViewId view = kNoView;  ///< whose photo the face shows; none: it is filled from around
  bool whole = false;     ///< the photo shows all of the face; else others may show the rest
};

/// \param out a result of texture, with model.obj, labels.npy and tags.npy \param place in the coordinates of the
/// mesh that was textured. Throws InputError where a file is missing or not of the same result. O(faces).
ShownPlace shown_at(const std::filesystem::path& out, const WorldPoint& place);

}  // namespace gpvc::evaluate
