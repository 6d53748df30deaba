// How large a pixel is in the world, and by how much charts are reduced to the density asked for.
#pragma once

#include <cstdint>
#include <span>

#include "atlas/charts/triangle_spans.h"
#include "io/scene.h"

namespace gpvc::atlas {

double texel_area(const TexelTriangle& corners);

/// Edge, in world units, of a pixel of the frame on the faces: the root of their areas' ratio, world to frame. Zero
/// where either area is. `corners` are frame positions.
double pixel_size(const Mesh& mesh, std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners);

/// Texels a pixel of that size is worth, at most 1; steps of an eighth of an octave, never coarser than asked, so that
/// neighbours can share charts. `texel_size` in world units; 0 asks for nothing.
double scale_for(double texel_size, double pixel_size);

}  // namespace gpvc::atlas
