// Faces that repeat an earlier face.
#pragma once

#include <optional>

#include "io/scene.h"

namespace gpvc::visibility {

/// The mesh with every face that has the corners of an earlier one, in the same turn, collapsed to its first corner,
/// whatever the corner it begins with and the numbers of its vertices; nothing when there is none. Where depths are equal
/// and both faces turn the same side to the camera, the lower index is in front: such a copy is never seen, and hides
/// nothing that the earlier face does not hide. So classes stay as they are, and thousands of copies of a large face are
/// not drawn and contested pixel by pixel. O(faces) expected, TBB; 16 to 24 bytes a face meanwhile.
std::optional<Mesh> collapse_copies(const Mesh& mesh);

}  // namespace gpvc::visibility
