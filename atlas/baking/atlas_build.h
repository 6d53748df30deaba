// The atlas under construction: what baking reads, and the pages that it fills.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/coverage_index.h"
#include "atlas/baking/pages.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/color_correction.h"

namespace gpvc::atlas {

/// Borrows the input and what the plan made of it.
struct AtlasBuild {
  const AtlasInput& input;
  const AtlasOptions& options;
  const CoverageIndex& coverage;
  const FaceNeighbours& neighbours;
  const ChartSet& set;
  ColorCorrection correction;
  std::vector<ChartPlace> places;  ///< per chart
  std::vector<Page> pages;

  Page& page_of(std::uint32_t chart) { return pages[places[chart].page]; }
};

}  // namespace gpvc::atlas
