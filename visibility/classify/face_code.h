// The result of scanning a face, in shaders or on the CPU.
#pragma once

#include <cstdint>

namespace gpvc::visibility {

/// Numbered as in shaders/codes.glsl. `unstored` is for CoverageCorrection::exact alone.
enum class FaceCode : std::uint8_t {
  hidden = 0,
  partial = 1,    ///< exact: some samples are stored as the face's, or all are and the face leaves the frame
  full = 2,       ///< exact: all samples are stored as the face's, and it lies in the frame
  no_centre = 3,  ///< a front face that reaches the frame but contains no pixel centre of it
  unstored = 4,   ///< a front face with samples, none of them stored as its own
  unsure = 5,     ///< left to the CPU; for `paper` and `off`: a large face
};

}  // namespace gpvc::visibility
