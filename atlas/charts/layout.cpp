#include "atlas/charts/layout.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/charts/given_charts.h"
#include "io/box.h"
#include "io/grouping.h"
#include "io/morton.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// The mean of the faces' middles.
WorldPoint mean_middle(const Mesh& mesh, const Chart& chart) {
  WorldPoint sum{0, 0, 0};
  for (const std::uint32_t face : chart.faces) sum = sum + middle_of(mesh, face);
  return (1 / static_cast<double>(chart.faces.size())) * sum;
}

/// Few photos are needed for a page whose charts lie close together in the world, however the photos are numbered (those
/// of a flight by line and camera). Plain charts of a view stay together, at the place that the view's charts have in
/// the mean. Partial charts, which need several photos each, have places of their own. Unseen charts come last, so that
/// few pages wait for all others.
void rank_charts(const AtlasInput& input, ChartSet& set) {
  std::vector<WorldPoint> middle(set.placed);
  tbb::parallel_for(std::size_t{0}, set.placed, [&](std::size_t c) {
    if (!set.charts[c].faces.empty()) middle[c] = mean_middle(input.mesh, set.charts[c]);
  });
  std::vector<WorldPoint> of_view(input.scene.views.size(), WorldPoint{0, 0, 0});
  std::vector<double> faces(of_view.size(), 0);
  Box box;
  for (std::size_t c = 0; c < set.placed; ++c) {
    const Chart& chart = set.charts[c];
    if (chart.kind == ChartKind::unseen) continue;
    box.add(middle[c]);
    const auto count = static_cast<double>(chart.faces.size());
    of_view[index(chart.view)] = of_view[index(chart.view)] + count * middle[c];
    faces[index(chart.view)] += count;
  }
  const MortonCurve curve(box);
  // Views at one place are told apart by their numbers.
  using Place = std::pair<std::uint64_t, std::uint32_t>;
  std::vector<Place> places(set.placed);
  for (std::size_t c = 0; c < set.placed; ++c) {
    const Chart& chart = set.charts[c];
    if (chart.kind == ChartKind::unseen) {
      places[c] = {std::numeric_limits<std::uint64_t>::max(), 0};
    } else if (chart.kind == ChartKind::plain) {
      const auto view = static_cast<std::uint32_t>(index(chart.view));
      places[c] = {curve.at((1 / faces[view]) * of_view[view]), view};
    } else {
      places[c] = {curve.at(middle[c]), 0};
    }
  }
  std::vector<Place> sorted = places;
  tbb::parallel_sort(sorted.begin(), sorted.end(), std::less<>());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  tbb::parallel_for(std::size_t{0}, set.placed, [&](std::size_t c) {
    set.charts[c].rank = static_cast<std::uint32_t>(std::ranges::lower_bound(sorted, places[c]) - sorted.begin());
  });
}

/// Packs the charts of each tile on pages of their own.
Packing pack_tiles(std::span<const Chart> charts, std::span<const PackShape> shapes, int page_size) {
  std::uint32_t tiles = 1;
  for (const Chart& chart : charts) tiles = std::max(tiles, chart.tile + 1);
  if (tiles == 1) return pack_shapes(shapes, page_size);
  const auto of_tile = group_items<std::uint32_t>(tiles, [&](const auto& add) {
    for (std::uint32_t c = 0; c < charts.size(); ++c) add(charts[c].tile, c);
  });
  std::vector<Packing> packings(tiles);
  tbb::parallel_for(std::size_t{0}, packings.size(), [&](std::size_t t) {
    std::vector<PackShape> mine;
    for (const std::uint32_t c : of_tile[t]) mine.push_back(shapes[c]);
    if (!mine.empty()) packings[t] = pack_shapes(mine, page_size);
  });
  Packing all;
  all.placements.resize(shapes.size());
  for (std::size_t t = 0; t < packings.size(); ++t) {
    const auto before = static_cast<std::uint32_t>(all.pages.size());
    for (std::size_t i = 0; i < of_tile[t].size(); ++i) {
      Placement& place = all.placements[of_tile[t][i]] = packings[t].placements[i];
      place.page += before;
    }
    all.pages.insert(all.pages.end(), packings[t].pages.begin(), packings[t].pages.end());
  }
  return all;
}

Layout lay_out_reduced(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
                       const CoverageIndex& coverage, double reduction) {
  Layout layout;
  layout.reduction = reduction;
  layout.edge = block_edge(options.padding);
  layout.set = make_charts(input, options, neighbours, coverage, reduction);
  layout.shapes.resize(layout.set.placed);
  tbb::parallel_for(std::size_t{0}, layout.set.placed, [&](std::size_t i) {
    layout.shapes[i] = chart_shape(layout.set.charts[i], layout.set.corners, options.padding, options.page_size);
  });
  rank_charts(input, layout.set);
  std::vector<PackShape> shapes;
  for (std::size_t i = 0; i < layout.shapes.size(); ++i) {
    shapes.push_back(layout.shapes[i].blocks);
    shapes.back().rank = layout.set.charts[i].rank;
  }
  layout.packing = pack_tiles(std::span(layout.set.charts).first(layout.set.placed), shapes,
                              options.page_size / block_edge(options.padding));
  return layout;
}

/// Charts share nothing but pages, whose blocks are single texels.
Layout lay_out_given(const AtlasInput& input, const FaceNeighbours& neighbours) {
  Layout layout;
  layout.set = make_given_charts(input, neighbours);
  for (const Chart& chart : std::span(layout.set.charts).first(layout.set.placed)) {
    layout.shapes.push_back({{chart.width, chart.height, {}, 0}, 0, 0});
    layout.packing.placements.push_back({input.layout->face_page[chart.faces[0]], static_cast<int>(chart.origin_x),
                                         static_cast<int>(chart.origin_y), 0});
  }
  for (const io::UvPage& page : input.layout->pages) layout.packing.pages.push_back({page.width, page.height});
  return layout;
}

/// The factor by which the texels exceed the limits; met up to 1.
double excess(const Packing& packing, const AtlasOptions& options) {
  const double texels = static_cast<double>(page_texels(packing, block_edge(options.padding)));
  const double page = static_cast<double>(options.page_size) * options.page_size;
  double result = options.max_texels ? texels / static_cast<double>(options.max_texels) : 0;
  // Texels alone do not tell whether the charts fit on the allowed pages.
  if (options.max_pages && packing.pages.size() > options.max_pages)
    result = std::max({result, texels / (static_cast<double>(options.max_pages) * page), 1.01});
  return result;
}

std::string limits_text(const AtlasOptions& options) {
  std::string text;
  if (options.max_pages) text += std::to_string(options.max_pages) + (options.max_pages == 1 ? " page" : " pages");
  if (options.max_texels) text += (text.empty() ? "" : " and ") + std::to_string(options.max_texels) + " texels";
  return text;
}

}  // namespace

std::size_t page_texels(const Packing& packing, int edge) {
  std::size_t sum = 0;
  for (const auto& p : packing.pages)
    sum += static_cast<std::size_t>(edge * p.width) * static_cast<std::size_t>(edge * p.height);
  return sum;
}

Layout lay_out(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
               const CoverageIndex& coverage) {
  if (input.layout != nullptr) return lay_out_given(input, neighbours);
  if (input.finished != nullptr)
    return lay_out_reduced(input, options, neighbours, coverage, input.finished->reduction);
  const auto at = [&](double reduction) { return lay_out_reduced(input, options, neighbours, coverage, reduction); };
  Layout best = at(1);
  double over = excess(best.packing, options);
  if (over <= 1) return best;
  best = {};  // the layout of a large mesh takes a gigabyte

  // Margins do not shrink, so texels fall a little less than with the square of the reduction: the square root of the
  // excess never reduces too much. Bisection every fourth round bounds the number of rounds.
  constexpr double kLeast = 1.0 / 4096, kEnough = 0.98;
  double fits = 0, too_large = 1, reduction = 1;
  for (int round = 0; round < 24; ++round) {
    const double guess = reduction * std::sqrt(kEnough / over);
    const bool between = guess > fits && guess < too_large;
    reduction = between && round % 4 != 3 ? guess : (fits + too_large) / 2;
    if (reduction < kLeast) break;
    Layout layout = at(reduction);
    over = excess(layout.packing, options);
    if (over <= 1) {
      fits = reduction;
      best = std::move(layout);
      if (over > 0.96) break;
    } else {
      too_large = reduction;
    }
    if (fits > 0.99 * too_large) break;
  }
  if (fits == 0)
    throw std::invalid_argument("even the smallest charts exceed the limit of " + limits_text(options) +
                                ": raise it, or the page size");
  return best;
}

}  // namespace gpvc::atlas
