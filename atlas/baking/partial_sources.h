// For faces that no view sees whole: the view that gives each texel its colour.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/coverage_index.h"
#include "atlas/baking/plane_map.h"
#include "atlas/baking/sampling.h"
#include "atlas/charts/chart_raster.h"
#include "atlas/charts/charts.h"
#include "io/grouping.h"

namespace gpvc::atlas {

/// How well a view shows a place on a face, worst first.
enum class Sight : std::uint8_t {
  hidden,
  beside_occluder,  ///< the face is hidden in a neighbouring pixel, which any resampling blends in
  near_occluder,    ///< the face is hidden within AtlasOptions::margin_px
  clear,
};

/// A view that shows a part of a face.
struct TexelSource {
  ViewId view{};
  const visibility::FaceCoverage* coverage = nullptr;  ///< nullptr: the view shows the whole face
  FrameFromTexel frame_from_texel;
  /// The face in the view's frame, relative to the coverage's box; nullopt if a corner lies behind the camera.
  std::optional<TexelTriangle> outline;
  /// Over the coverage's box, where it is not hidden; empty: clear everywhere. Dropped once sources are chosen.
  std::vector<Sight> clearance;
};

/// How well the source shows the place at (x, y) of its chart.
Sight sight_at(const TexelSource& source, const visibility::CoverageTable& table, double x, double y);

/// A chart of kind partial or flat while its texels are collected.
struct PartialChart {
  static constexpr std::uint8_t kNone = 255;
  static constexpr int kBlendSteps = 6;

  std::uint32_t chart = 0;
  ChartRaster raster;
  std::vector<std::uint32_t> views;      ///< that give it texels, ascending
  Grouped<TexelSource> sources;          ///< per face of the chart, best first
  std::vector<std::uint32_t> face_slot;  ///< per texel: the place of its owner in the chart's list of faces
  std::vector<std::uint8_t> best;        ///< per texel: which of its owner's sources, or kNone
  std::vector<std::uint8_t> second;      ///< blended in close to texels of another view, or kNone
  std::vector<std::uint8_t> blend;       ///< weight of the second source, in steps of 1 / kBlendSteps
  std::vector<Color> color;              ///< sum so far

  std::span<const TexelSource> sources_at(std::size_t texel) const { return sources[face_slot[texel]]; }
};

/// The charts of kind partial and flat, ascending.
std::vector<std::uint32_t> partial_charts(const ChartSet& set);

/// The texels of a partial chart and its ring.
CellBox partial_box(const Chart& chart);

/// Chooses the source of every texel of some of these charts. Reads no photo. O(texels x candidates), TBB.
std::vector<PartialChart> choose_sources(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage,
                                         int margin_px, std::span<const std::uint32_t> charts);

/// The origin of the texel around a position of the chart.
PointOrigin origin_at(const PartialChart& part, const TexelPoint& p);

}  // namespace gpvc::atlas
