// Charts and their places on pages, within the limits on pages and texels.
#pragma once

#include <vector>

#include "atlas/charts/chart_shape.h"
#include "atlas/charts/charts.h"
#include "atlas/packing/packing.h"

namespace gpvc::atlas {

struct Layout {
  ChartSet set;
  std::vector<ChartShape> shapes;  ///< per chart before those of the border
  Packing packing;
  double reduction = 1;  ///< factor on the scale of all charts that meets the limits
  int edge = 1;          ///< of the blocks in which pages are packed, texels
};

/// Texels of all pages. \param edge of a block, texels
std::size_t page_texels(const Packing& packing, int edge);

/// Where AtlasInput::layout has the faces, if there is one. Else at the density of AtlasInput::finished, if there is one; else
/// at full density, if that meets the limits; otherwise all charts are reduced by one factor until they do, with at least about
/// 96 % of the texels that the limits allow where possible. Throws std::invalid_argument if even the smallest charts exceed a limit.
Layout lay_out(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
               const CoverageIndex& coverage);

}  // namespace gpvc::atlas
