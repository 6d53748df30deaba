// What the definition of visibility says, by brute force: the judge of VisibilityStage.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "result.h"

namespace gpvc::visibility {

/// Visibility as result.h defines it, by brute force: every sample of every face against every triangle that covers it, in
/// doubles with error bounds and in exact arithmetic where these cannot tell. No OpenGL, no code shared with the stage.
struct OracleView {
  std::vector<FaceClass> classes;  ///< per face
  std::vector<std::uint8_t> tied;  ///< per face: 1 when an exact tie had a say: a sample within 1e-9 px of an edge, or
                                   ///< two depths within 1e-12 relative
  std::size_t samples = 0;         ///< pixel centres and sub-pixel samples decided
};

/// O(faces + the pixels that their projections cover), TBB, about 16 bytes a pixel. Deterministic for any number of
/// threads.
OracleView oracle_visibility(const Mesh& mesh, const View& view);

}  // namespace gpvc::visibility
