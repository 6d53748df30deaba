// The blocks of a page that a chart takes, such that mip levels keep charts apart.
//
// Pages are tiled by blocks of 2^k texels, the edge of the coarsest mip level's cell that must stay clean,
// and no two charts share a block: an average over any cell of that or a finer level holds one chart's
// colours.
//
//     |   ....|...    |     # chart    . its margin    | borders of blocks
//     |  .####|##.    |     Two blocks here; one, if the chart were moved left by three texels: of all
//     |  .####|##.    |     positions within a block the one that takes the fewest is chosen.
#pragma once

#include <span>

#include "atlas/charts/charts.h"
#include "atlas/packing/packing.h"

namespace gpvc::atlas {

/// Edge of a block: the largest power of two that is no more than the padding, so that with 8 three mip levels stay
/// clean.
int block_edge(int padding);

/// Texels around a chart that its blocks contain at least. A bilinear lookup on the border of a chart, on the level
/// whose cells have edge s, gives up to 1/2 - margin / s of its weight to another block's cell: with a quarter of the
/// block's edge nothing up to the last clean level but one, and at most 1/4 there.
int block_margin(int padding);

struct ChartShape {
  PackShape blocks;
  int inset_x = 0, inset_y = 0;  ///< texels from the corner of the first block to the chart's first texel
};

/// \pre the chart's box with block_margin on all sides is no larger than page_size
ChartShape chart_shape(const Chart& chart, std::span<const TexelTriangle> corners, int padding, int page_size);

}  // namespace gpvc::atlas
