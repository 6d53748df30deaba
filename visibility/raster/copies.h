// Faces that repeat others.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "io/scene.h"

namespace gpvc::visibility {

struct Repeats {
  /// The mesh with every face that has the corners of an earlier one, in the same turn, collapsed to its first corner,
  /// whatever the corner it begins with and the numbers of its vertices; nothing when there is none. Where depths are
  /// equal and both faces turn the same side to the camera, the lower index is in front: such a copy is never seen, and
  /// hides nothing that the earlier face does not hide. So classes stay as they are, and thousands of copies of a large
  /// face are not drawn and contested pixel by pixel.
  std::optional<Mesh> collapsed{};
  /// Per face 1 where another one has its corners in the other turn: the other side of a surface. The one that turns its
  /// back to a camera need not be drawn, since the other covers the same pixels at the same depths and is in front.
  /// Empty when there is none.
  std::vector<std::uint8_t> doubled{};
};

/// O(faces) expected, TBB; 16 to 24 bytes a face meanwhile.
Repeats find_repeats(const Mesh& mesh);

}  // namespace gpvc::visibility
