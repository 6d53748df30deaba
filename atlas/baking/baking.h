// The atlas under construction, and how its pages get colours from the photos.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/pages.h"
#include "atlas/baking/partial_sources.h"
#include "atlas/blending/blend_weights.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/color_correction.h"
#include "atlas/sampling/coverage_index.h"
#include "atlas/sampling/each_photo.h"

namespace gpvc::atlas {

struct AtlasBuild;
class Poll;

/// Per texel of a page of a given layout, row-major, the chart that it belongs to, or kNoOwner: one that has its middle, else
/// one that touches it, else one whose ring has it, of several the first. O(texels + texels that faces cover), TBB.
std::vector<std::uint32_t> texel_owners(const AtlasBuild& build, std::uint32_t page);

/// What baking reads, and the pages that it fills. Borrows the input and what the plan made of it.
struct AtlasBuild {
  const AtlasInput& input;
  const AtlasOptions& options;
  const CoverageIndex& coverage;
  const FaceNeighbours& neighbours;
  const ChartSet& set;
  const BlendWeights& blending;
  ColorCorrection correction;
  BandPainting painting;
  std::vector<ChartPlace> places;  ///< per chart before those of the border
  std::vector<Page> pages;
  std::vector<PageMean> spilled_means = {};  ///< per page: when it was last spilled, before it was padded

  /// Opens a page, with the owners of its texels where the layout is given.
  void open(std::uint32_t page) {
    pages[page].open();
    if (input.layout != nullptr) pages[page].block_owner = texel_owners(*this, page);
  }
  /// Where a texel of a chart lies on its page; nullopt beyond the page, and where it belongs to another chart: texels around
  /// charts of given layouts alone do.
  std::optional<ChartPlace::Texel> own_texel(std::uint32_t chart, int x, int y) const {
    const ChartPlace::Texel texel = places[chart].texel(x, y);
    const Page& page = page_of(chart);
    const bool inside = texel.x >= 0 && texel.y >= 0 && texel.x < page.image.width && texel.y < page.image.height;
    return inside && page.owner(texel.x, texel.y) == chart ? std::optional(texel) : std::nullopt;
  }

  /// The corners of a chart's face on its page.
  TexelTriangle on_page(std::uint32_t chart, std::size_t face) const {
    TexelTriangle corners = set.corners[face];
    for (TexelPoint& p : corners) p = places[chart].point(p);
    return corners;
  }
  Page& page_of(std::uint32_t chart) { return pages[places[chart].page]; }
  const Page& page_of(std::uint32_t chart) const { return pages[places[chart].page]; }
  /// Mean over all pages as they are, or were when they were spilled.
  PageMean mean_color() const {
    PageMean mean;
    for (std::size_t p = 0; p < pages.size(); ++p) {
      PageMean open;
      if (pages[p].is_open()) open.add(pages[p]);
      mean.add(pages[p].is_open() ? open : spilled_means[p]);
    }
    return mean;
  }
};

/// Bakes a band of a plain chart of a given layout: texel by texel, through the plane of the face that owns it. \param faces that
/// reach into the band. O(texels + pixels below them).
void bake_given_band(AtlasBuild& build, const ViewPhoto& photo, std::uint32_t chart, int band,
                     std::span<const std::uint32_t> faces, Poll& poll);

/// Pages from `first` up to `end`.
struct PageRange {
  std::uint32_t first = 0, end = 0;
  bool has(std::uint32_t page) const { return page >= first && page < end; }
};

/// The plain charts on these pages, ascending.
std::vector<std::uint32_t> plain_charts_on(const AtlasBuild& build, const PageRange& pages);

/// Copies or resamples every texel of the plain charts on some open pages, and adds to partial charts what each view gives
/// them. Every photo is fetched once; the next ones are decoded while one is in use. Without padding the rings of charts are
/// left out.
/// Progress is called per view, and ten times a second within one, from any thread, but by one thread at a time; an
/// exception from it ends the work. O(texels + pixels covered by charts with texels of many pixels).
void bake_photos(AtlasBuild& build, const PageRange& plain, std::span<PartialChart> partial, PhotoOrder order,
                 const Progress& progress);

/// Adds to the texels of the plain charts on some open pages what other views give to their coarse colours (blending/). In batches of
/// charts whose sums take about so many bytes, one chart at least, for each of which the coarse colours of its views are fetched.
/// Progress as for bake_photos(). O(texels x views that show them).
InventedColor blend_charts(AtlasBuild& build, const PageRange& pages, std::size_t bytes, const Progress& progress);

/// Writes the texels that a view alone gives to a partial chart, and adds its part to those that it shares with another.
/// \pre the chart's page is open
void take_view(PartialChart& part, AtlasBuild& build, const ViewPhoto& photo);

/// Writes the texels that two views share. \pre take_view() has been called for all of the chart's views
void write_blended(const PartialChart& part, AtlasBuild& build);

}  // namespace gpvc::atlas
