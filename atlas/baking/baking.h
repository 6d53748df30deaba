// The atlas under construction, and the steps that fill its pages, in their order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/coverage_index.h"
#include "atlas/baking/each_photo.h"
#include "atlas/baking/pages.h"
#include "atlas/baking/partial_sources.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/color_correction.h"

namespace gpvc::atlas {

/// What baking reads, and the pages that it fills. Borrows the input and what the plan made of it.
struct AtlasBuild {
  const AtlasInput& input;
  const AtlasOptions& options;
  const CoverageIndex& coverage;
  const FaceNeighbours& neighbours;
  const ChartSet& set;
  ColorCorrection correction;
  std::vector<ChartPlace> places;  ///< per chart before those of the border
  std::vector<Page> pages;

  Page& page_of(std::uint32_t chart) { return pages[places[chart].page]; }
};

/// Copies or resamples every texel of the plain charts, and adds to partial charts what each view gives them. Every
/// photo is fetched once; the next is decoded while one is in use. Without padding the rings of charts are left out.
/// Progress is called per view, and ten times a second within one, from any thread, but by one thread at a time; an
/// exception from it ends the work. O(texels + pixels covered by charts with texels of many pixels).
void bake_photos(AtlasBuild& build, std::span<PartialChart> partial, const Progress& progress);

/// Adds the texels that a view gives to a partial chart.
void take_view(PartialChart& part, const AtlasBuild& build, const ViewPhoto& photo);

/// Writes the partial charts to their pages. Texels that no view shows are filled smoothly from those around them, on
/// the same chart and, across its border, on the charts beside it. \pre plain charts are baked
void finish_partial(std::span<PartialChart> parts, AtlasBuild& build);

/// Writes the charts of unseen faces. In each hole, vertex colours are the harmonic function (uniform edge weights)
/// that continues the colours on the hole's border; within a face they are interpolated linearly. A hole without a
/// border, where a whole component of the mesh is unseen, takes the mean colour of all pages. \pre all other charts are
/// baked. O(faces + unseen faces x CG iterations).
void fill_unseen(AtlasBuild& build);

/// Writes the same charts in options.unseen_color.
void paint_unseen(AtlasBuild& build);

}  // namespace gpvc::atlas
