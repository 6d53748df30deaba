// What leveling adds, kept within what photos show.
#pragma once

#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/blending/blend_weights.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/color_correction.h"

namespace gpvc::atlas {

/// Grey levels by which a levelled and blended colour may leave the range of the photos' colours of the place, of which
/// InventedColor::kTolerance is twice as much: half of it is left to what lies between vertices.
inline constexpr float kOffsetTolerance = InventedColor::kTolerance / 2;

/// Per channel, the range for the sum of offset and strip. Within it, the blended coarse colour of a place stays between the darkest
/// and the brightest coarse colour that the blended photos show there, their exposure corrected, give or take kOffsetTolerance.
/// `most` may be below 0, and `least` above: what blending does beyond the range is its own.
struct AddedRange {
  Color least, most;
};

/// Per node of `correction`; infinite ones where a single photo is blended or none is. At a seam itself both of its photos are
/// among them. Reads all coarse photos once. O(vertices x views), TBB; 6 bytes for each vertex and view meanwhile.
/// \pre correction has its exposure and nodes
std::vector<AddedRange> find_added_ranges(const AtlasInput& input, const BlendWeights& blending,
                                          const ColorCorrection& correction);

/// Makes offsets smaller, never larger or of the other sign, so that they keep to their node's range. An offset fades over many
/// edges from its seam; where photos agree with each other on the way, it would be a colour that none of them has. O(nodes).
void limit_offsets(std::span<const AddedRange> ranges, ColorCorrection& correction);

/// Sets `strip_shares`, so that offsets and strips together keep to the ranges: strips reach kStripWidth texels into faces, over
/// what photos agree on as well. \pre limit_offsets(); strips are laid. O(faces), TBB.
void limit_strips(std::span<const AddedRange> ranges, const AtlasInput& input, const ChartSet& set,
                  ColorCorrection& correction);

}  // namespace gpvc::atlas
