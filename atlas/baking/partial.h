// Faces no view sees whole: each texel from the best view that shows this very face there.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/pages.h"
#include "atlas/charts/chart_raster.h"
#include "atlas/leveling/color_correction.h"

namespace gpvc::atlas {

/// A view that shows a part of a face, and where in its frame a chart's texels lie: (x, y, 1) times the matrix is (u w,
/// v w, w) with w > 0 in front of the camera.
struct TexelSource {
  ViewId view{};
  const visibility::FaceCoverage* coverage = nullptr;  ///< nullptr: shows all of it
  std::array<double, 9> frame_from_texel{};
  /// The face in the view's frame, from the coverage's corner; nullopt where a part lies behind the camera.
  std::optional<TexelTriangle> outline;
  /// Over the coverage's box: 0 clear, 1 seen, but close to something in front, 2 right beside it. Empty once the
  /// sources of its chart are chosen, which alone looks at it.
  std::vector<std::uint8_t> margin;
};

/// A chart of kind partial or flat while its texels are collected.
struct PartialChart {
  std::uint32_t chart = 0;
  ChartRaster raster;
  std::vector<std::uint32_t> views;         ///< that give it texels, ascending
  std::vector<std::size_t> first_source;    ///< per face of the chart, into sources
  std::vector<TexelSource> sources;         ///< per face, best first
  std::vector<std::uint32_t> face_slot;     ///< per texel: the owner's place in the chart's faces
  std::vector<std::uint8_t> best;           ///< per texel: which source of its owner, or kNone
  std::vector<std::uint8_t> second;         ///< blended in near the border to another view's texels, or kNone
  std::vector<std::uint8_t> second_sixths;  ///< its share, in sixths
  std::vector<Color> color;                 ///< sum so far

  static constexpr std::uint8_t kNone = 255;
};

/// Chooses the source of every texel; reads no photo. Margin: see AtlasOptions::margin_px. O(texels x candidates).
std::vector<PartialChart> choose_sources(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage,
                                         int margin_px);

/// What the texel around a position of the chart is to be taken from.
PointOrigin origin_at(const PartialChart& part, const TexelPoint& p);

/// Adds the texels that `view` gives.
void take_view(PartialChart& part, const ChartSet& set, const visibility::CoverageTable& table, const View& view,
               ViewId id, const Image& photo, const ColorCorrection& correction);

/// Writes the charts to their pages. Texels that no view shows take their colour from those around them, on the same
/// chart and, along its border, on the plain charts beside it. \pre plain charts are baked
void finish_partial(std::span<PartialChart> parts, const AtlasInput& input, const ChartSet& set,
                    const FaceNeighbours& neighbours, std::span<const ChartPlace> places, int padding,
                    std::span<Page> pages);

}  // namespace gpvc::atlas
