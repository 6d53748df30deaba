// Charts, their blocks and their places, within the limits on pages and texels.
#pragma once

#include <vector>

#include "atlas/charts/chart_shape.h"
#include "atlas/charts/charts.h"
#include "atlas/packing/packing.h"

namespace gpvc::atlas {

struct Layout {
  ChartSet set;
  std::vector<ChartShape> shapes;  ///< per chart
  Packing packing;
  double reduction = 1;  ///< of all charts, to meet the limits
};

/// \param edge of a block, texels
std::size_t page_texels(const Packing& packing, int edge);

/// Full density where that meets the limits; else the one reduction of all charts that does and, within about 2 % of
/// the texels, no more. Throws std::invalid_argument where the smallest charts there can be exceed a limit.
Layout lay_out(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
               const CoverageIndex& coverage);

}  // namespace gpvc::atlas
