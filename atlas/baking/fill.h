// Colour for faces that no view shows.
#pragma once

#include <span>

#include "atlas/atlas.h"
#include "atlas/baking/pages.h"
#include "atlas/charts/charts.h"

namespace gpvc::atlas {

/// Writes the charts of kind blocks. Per hole, vertex colours are the harmonic function (uniform edge weights) that
/// continues the colours on the hole's border; within a face they are interpolated linearly. A hole without border, a
/// whole component unseen, takes the mean colour of all pages. \pre all other charts are baked. O(faces + unseen faces
/// * CG iterations).
void fill_unseen(const AtlasInput& input, const ChartSet& set, std::span<const ChartPlace> places,
                 std::span<Page> pages);

/// The same in one colour.
void paint_unseen(const ChartSet& set, std::span<const ChartPlace> places, const std::array<std::uint8_t, 3>& color,
                  std::span<Page> pages);

}  // namespace gpvc::atlas
