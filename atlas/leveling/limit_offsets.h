// Offsets within what photos show.
#pragma once

#include "atlas/atlas.h"
#include "atlas/blending/blend_weights.h"
#include "atlas/leveling/color_correction.h"

namespace gpvc::atlas {

/// Grey levels by which a levelled and blended colour may leave the range of the photos' colours of the place, of which
/// InventedColor::kTolerance is twice as much: half of it is left to what lies between vertices.
inline constexpr float kOffsetTolerance = InventedColor::kTolerance / 2;

/// Reduces offsets at vertices that several photos are blended at, with which a channel of the coarse colour would leave the
/// range of those of all of these photos, their exposure corrected, by more than kOffsetTolerance. An offset fades over many edges
/// from its seam; where photos agree with each other on the way, it would be a colour that none of them has. At a seam itself both
/// of its photos are among them. Reads all coarse photos once. O(vertices x views), TBB; 6 bytes for each vertex and view.
void limit_offsets(const AtlasInput& input, const BlendWeights& blending, ColorCorrection& correction);

}  // namespace gpvc::atlas
