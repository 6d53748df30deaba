// What the classification shader answers for a face.
#pragma once

#include <cstdint>

namespace gpvc {

/// Numbered as in shaders/hivers.comp. no_centre: a front face whose projection contains no pixel centre.
enum class FaceCode : std::uint32_t { hidden = 0, partial = 1, full = 2, no_centre = 3 };

}  // namespace gpvc
