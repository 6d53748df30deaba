// How many pieces a model's texture is cut into.
#pragma once

#include <cstddef>

#include "io/textured_model.h"

namespace gpvc::evaluate {

/// Groups of textured faces that are connected through edges at which both faces have the same vertices, texture
/// coordinates (by value) and page: what other programs' models have in place of our patches. A chart that its program
/// cut without need counts as several. O(n log n) of faces.
std::size_t texture_islands(const io::TexturedModel& model);

}  // namespace gpvc::evaluate
