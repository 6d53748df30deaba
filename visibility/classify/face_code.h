// What the classification shaders answer for a face.
#pragma once

#include <cstdint>

namespace gpvc::visibility {

/// Numbered as in shaders/codes.glsl. `unstored` is for CoverageCorrection::exact alone.
enum class FaceCode : std::uint8_t {
  hidden = 0,
  partial = 1,    ///< exact: some sample is stored as the face's, or all but it reaches beyond the frame
  full = 2,       ///< exact: all samples are stored as the face's, and it lies in the frame
  no_centre = 3,  ///< a front face that reaches the frame but contains no pixel centre of it
  unstored = 4,   ///< a front face with samples, none of them stored as its own
  unsure = 5,     ///< left to the CPU; for `paper` and `off`: a large face
};

}  // namespace gpvc::visibility
