// The blocks of a page that a chart takes, chosen so that mip levels do not mix charts.
//
// Pages are tiled by blocks of 2^k x 2^k texels, the cells of the coarsest mip level that must not mix charts. No two
// charts share a block, so an average over any cell of that level or a finer one holds the colours of one chart.
//
//     |   ....|...    |     # chart    . its margin    | borders of blocks
//     |  .####|##.    |     This chart takes two blocks; moved left by three texels it would take one. Of all
//     |  .####|##.    |     positions within a block, the one that takes the fewest blocks is chosen.
#pragma once

#include <span>

#include "atlas/charts/charts.h"
#include "atlas/packing/packing.h"

namespace gpvc::atlas {

/// Edge of a block: the largest power of two up to the padding. With 8, the first three mip levels do not mix charts.
int block_edge(int padding);

/// Least distance, in texels, from a chart to the border of its blocks: a quarter of a block's edge. A bilinear lookup
/// on the border of a chart, in the mip level whose cells have edge s, gives up to 1/2 - margin / s of its weight to a
/// cell of another block. That is at most 1/4 in the level whose cells are blocks, and nothing in finer levels.
int block_margin(int padding);

struct ChartShape {
  PackShape blocks;
  int inset_x = 0, inset_y = 0;  ///< texels from the corner of the first block to the chart's first texel
};

/// \pre the chart's box with block_margin on all sides is no larger than page_size
ChartShape chart_shape(const Chart& chart, std::span<const TexelTriangle> corners, int padding, int page_size);

}  // namespace gpvc::atlas
