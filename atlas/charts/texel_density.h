// The size of a pixel in the world, and the scale of charts for a wanted texel density.
#pragma once

#include <cstdint>
#include <span>

#include "atlas/charts/triangle_spans.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// Edge, in world units, of a pixel projected onto the faces: the root of their area in the world over that in the
/// frame; zero if either is. `corners` are frame positions.
double pixel_size(const Mesh& mesh, std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners);

/// Scale, at most 1, that makes texels of `texel_size` (world units; 0: no reduction) from pixels of `pixel_size`.
/// Rounded up to steps of an eighth of an octave, so that neighbouring parts can share charts.
double scale_for(double texel_size, double pixel_size);

}  // namespace gpvc::atlas
