// For faces that no view sees whole: the view that gives each texel its colour.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/plane_map.h"
#include "atlas/charts/chart_raster.h"
#include "atlas/charts/charts.h"
#include "atlas/sampling/color.h"
#include "atlas/sampling/coverage_index.h"
#include "io/grouping.h"

namespace gpvc::atlas {

/// How well a view shows a place on a face, worst first.
enum class Sight : std::uint8_t {
  hidden,
  beside_occluder,  ///< the face is hidden in a neighbouring pixel, which any resampling blends in
  near_occluder,    ///< the face is hidden within AtlasOptions::margin_px
  clear,
};

/// How well a view shows a face in pixels where it is not hidden: a bit for each pixel of the coverage's box, in rows of whole
/// words. Empty: clear everywhere.
struct Clearance {
  std::size_t words = 0;                    ///< of a row
  std::vector<std::uint64_t> beside, near;  ///< what the former has, the latter has as well
  bool is_whole = false;                    ///< the face lies in the box, and is hidden nowhere
  Sight at(int x, int y) const {
    if (near.empty()) return Sight::clear;
    const auto column = static_cast<std::size_t>(x), word = static_cast<std::size_t>(y) * words + column / 64;
    const auto has = [&](const std::vector<std::uint64_t>& bits) { return (bits[word] >> (column % 64) & 1) != 0; };
    return !has(near) ? Sight::clear : has(beside) ? Sight::beside_occluder : Sight::near_occluder;
  }
};

/// A view that shows a part of a face.
struct TexelSource {
  std::uint32_t face = 0;
  ViewId view{};
  const visibility::FaceCoverage* coverage = nullptr;  ///< nullptr: the view shows the whole face
  FrameFromTexel frame_from_texel;
  /// The face in the view's frame, relative to the coverage's box; nullopt if a corner lies behind the camera.
  std::optional<TexelTriangle> outline;
  Clearance clearance;  ///< dropped once sources are chosen
};

/// How well the source shows the place at (x, y) of its chart.
Sight sight_at(const TexelSource& source, const visibility::CoverageTable& table, double x, double y);

/// The part of a chart's row, from `low` to `high`, whose places lie so deep in the face's outline, in the view, that the centre of
/// their own pixel does, too. There the coverage of that pixel answers; near the outline one has to search. Deep is 0.51 px: half a
/// pixel along both axes, and a hundredth for rounding.
struct InnerRow {
  double low = 1, high = 0;
  bool has(double x) const { return low <= x && x <= high; }
};

/// None for a source without an outline. O(1).
InnerRow inner_row(const TexelSource& source, double y);

/// The same sight, found faster in the inner part of the row. \pre row = inner_row(source, y)
Sight sight_at(const TexelSource& source, const visibility::CoverageTable& table, const InnerRow& row, double x,
               double y);

/// What a source gives to the colours of texels beside each other in a row.
struct TexelShares {
  std::uint32_t texel = 0;   ///< the first one; of the chart's partial_box(), row-major
  std::uint32_t source = 0;  ///< of PartialChart::sources
  std::uint8_t weight = 0;   ///< in steps of 1 / PartialChart::kBlendSteps; all of them: no other source gives anything
  TexelReach reach = TexelReach::outside;
  std::uint8_t count = 0;  ///< of texels; they lie in one block
};

/// A texel with shares of two views.
struct BlendedTexel {
  std::uint32_t texel = 0;
  TexelReach reach = TexelReach::outside;
  Color color;  ///< sum so far
};

/// A chart of kind partial or flat while its texels are collected. Holds what is on the page alone: most of the chart's
/// box lies outside the faces, and many texels on them are seen by no view.
struct PartialChart {
  static constexpr std::uint8_t kBlendSteps = 6;

  std::uint32_t chart = 0;
  std::vector<TexelSource> sources;   ///< those that give a texel something
  std::vector<std::uint32_t> views;   ///< that give it texels, ascending
  Grouped<TexelShares> shares;        ///< by place in `views`; in blocks of kStripRow x kStripRow texels, row by row
  std::vector<BlendedTexel> blended;  ///< ascending by texel
  std::vector<Color> layer_sums;      ///< per entry of `blended` and layer after the first, as BlendedTexel::color
  std::vector<bool> known;            ///< per texel of partial_box(): it has a colour, or will have it
  bool is_open = false;               ///< texels on the page have no colour

  /// Empty if the view gives it no texels.
  std::span<const TexelShares> shares_of(ViewId view) const;
  /// Makes room for the sums of so many layers after the first, if there is none yet.
  void open_sums(std::size_t layers) { layer_sums.resize(layers * blended.size()); }
  /// Adds to what a texel with shares of two views gets in each layer.
  void add_to_sums(std::uint32_t texel, float share, std::span<const Color> layers) {
    const auto place = std::ranges::lower_bound(blended, texel, {}, &BlendedTexel::texel);
    place->color = place->color + share * layers[0];
    const auto first = static_cast<std::size_t>(place - blended.begin()) * (layers.size() - 1);
    for (std::size_t l = 1; l < layers.size(); ++l)
      layer_sums[first + l - 1] = layer_sums[first + l - 1] + share * layers[l];
  }
  /// Of the layers after the first, of an entry of `blended`.
  std::span<const Color> sums_of(std::size_t entry) const {
    const std::size_t layers = blended.empty() ? 0 : layer_sums.size() / blended.size();
    return std::span(layer_sums).subspan(entry * layers, layers);
  }
  /// With the sums of so many layers after the first.
  std::size_t bytes(std::size_t later_layers) const;
};

/// The charts of kind partial and flat, ascending.
std::vector<std::uint32_t> partial_charts(const ChartSet& set);

/// The texels of a partial chart and its ring.
CellBox partial_box(const Chart& chart);

/// Bytes that a chart takes, about, while its sources are chosen, and the most that their clearances may take; what is
/// kept of it is less by far. O(entries that the coverage has of its faces).
std::size_t choosing_bytes(const Chart& chart, const CoverageIndex& coverage, int margin_px);

/// Chooses the sources of every texel of some of these charts, in their order. Reads no photo. O(texels x candidates), TBB.
std::vector<PartialChart> choose_sources(const AtlasInput& input, const AtlasOptions& options, const ChartSet& set,
                                         const CoverageIndex& coverage, std::span<const std::uint32_t> charts);

/// The origin of the texel around a position of the chart. O(views log texels).
PointOrigin origin_at(const PartialChart& part, const Chart& chart, const TexelPoint& p);

}  // namespace gpvc::atlas
