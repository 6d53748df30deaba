// What the classification shaders answer for a face.
#pragma once

#include <cstdint>

namespace gpvc::visibility {

/// Numbered as in shaders/codes.glsl. `unstored` is for CoverageCorrection::exact alone.
enum class FaceCode : std::uint8_t {
  hidden = 0,
  partial = 1,    ///< exact: some sample is stored as the face's, or all but it reaches beyond the frame
  full = 2,       ///< exact: all samples are stored as the face's, and it lies in the frame
  no_centre = 3,  ///< a front face whose projection contains no pixel centre
  unstored = 4,   ///< a front face with samples, none of them stored as its own
  unsure = 5,     ///< the CPU must look at it; for `paper` and `off`: at a large one, or beyond the frame
};

}  // namespace gpvc::visibility
