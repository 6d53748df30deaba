// The atlas under construction, and the steps that fill its pages, in their order.
#pragma once

#include <cstdint>
#include <optional>
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

/// Colours of places on pages that are closed before the colours are used, in the order of their use.
struct KeptColors {
  struct Place {
    std::uint32_t page = 0;
    TexelPoint at;
  };
  std::vector<Place> places;
  std::vector<std::optional<Color>> colors;  ///< per place; nullopt where nothing is baked

  void want(std::uint32_t page, const TexelPoint& at) { places.push_back({page, at}); }
  /// Keeps look(page, place) for the places on a page.
  template <typename Look>
  void take(std::uint32_t number, const Page& page, const Look& look) {
    colors.resize(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      if (places[i].page == number) colors[i] = look(page, places[i].at);
  }
};

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
  /// Pages from here on are baked last and together: they have the charts that take colours from charts beside them.
  std::uint32_t first_last_page = 0;
  std::vector<KeptColors> kept_beside = {};  ///< per chart: for its border, from earlier pages; empty: nothing kept
  KeptColors kept_at_holes = {};             ///< for the borders of holes
  PageMean early_mean = {};                  ///< of earlier pages

  Page& page_of(std::uint32_t chart) { return pages[places[chart].page]; }
  bool is_early(std::uint32_t page) const { return page < first_last_page; }
  /// Mean over early pages and those that are open.
  Color mean_color() const {
    PageMean mean = early_mean;
    for (const Page& page : pages) mean.add(page);
    return mean.mean();
  }
};

enum class PlainCharts { bake, skip };

/// Copies or resamples every texel of the plain charts on open pages, and adds to partial charts what each view gives
/// them. Every photo is fetched once; the next ones are decoded while one is in use. Without padding the rings of charts are left out.
/// Progress is called per view, and ten times a second within one, from any thread, but by one thread at a time; an
/// exception from it ends the work. O(texels + pixels covered by charts with texels of many pixels).
void bake_photos(AtlasBuild& build, PlainCharts plain, std::span<PartialChart> partial, PhotoOrder order,
                 const Progress& progress);

/// Note the places on early pages whose colours fill_partial() and fill_unseen() will use.
void want_beside_partial(AtlasBuild& build);
void want_at_holes(AtlasBuild& build);
/// Keep these colours of an early page. \pre the page is baked, and not yet padded
void keep_beside_partial(AtlasBuild& build, std::uint32_t page);
void keep_at_holes(AtlasBuild& build, std::uint32_t page);

/// Adds the texels that a view gives to a partial chart.
void take_view(PartialChart& part, const AtlasBuild& build, const ViewPhoto& photo);

/// A partial chart with texels that no view shows.
struct OpenChart {
  std::uint32_t chart = 0;
  std::vector<bool> known;  ///< per texel of partial_box(): its colour is on the page
};

/// Writes the texels of partial charts that have got a colour, and returns the charts that have others as well.
std::vector<OpenChart> write_known(std::span<const PartialChart> parts, AtlasBuild& build);

/// Fills the other texels smoothly from those around them, on the same chart and, across its border, on the charts beside
/// it. \pre all other charts with a view are baked, on open pages or early ones
void fill_partial(std::vector<OpenChart> open, AtlasBuild& build);

/// Writes the charts of unseen faces. In each hole, vertex colours are the harmonic function (uniform edge weights)
/// that continues the colours on the hole's border; within a face they are interpolated linearly. A hole without a
/// border, where a whole component of the mesh is unseen, takes the mean colour of all pages. \pre all other charts are
/// baked. O(faces + unseen faces x CG iterations).
void fill_unseen(AtlasBuild& build);

/// Writes the same charts in options.unseen_color.
void paint_unseen(AtlasBuild& build);

}  // namespace gpvc::atlas
