// A coarse look at how far a mesh lies from a view.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "../../io/scene.h"
#include "framing.h"

namespace gpvc::checks {

/// The first faces that rays through the middles of kColumns x kRows cells of a view's frame hit, by rows.
struct CoarseDepths {
  static constexpr std::size_t kColumns = 64, kRows = 48;
  /// Along the view's axis; infinite where no face is hit.
  std::vector<float> depths = std::vector<float>(kColumns * kRows, std::numeric_limits<float>::infinity());
  std::vector<bool> backs = std::vector<bool>(kColumns * kRows);  ///< true where the face is seen from behind
  static WorldPoint ray(const Camera& camera, std::size_t column, std::size_t row);  ///< in the camera's axes, z = 1
};
/// O(faces in framed runs + cells that they cover).
CoarseDepths draw_coarse_depths(const Mesh& mesh, const FaceRuns& runs, const View& view);

}  // namespace gpvc::checks
