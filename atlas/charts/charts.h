// Charts: sets of faces that share a piece of a page, and where their corners lie in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/coverage_index.h"
#include "atlas/charts/triangle_spans.h"

namespace gpvc::atlas {

enum class ChartKind : std::uint8_t {
  /// Faces of one view, their texels copied from it: frame = origin + texel / scale. Connected, but for pieces of the
  /// photo whose paddings would overlap: these keep their places and share a chart.
  plain,
  /// As plain, but every texel comes from the best view that shows it; no texel centre lies in two faces.
  partial,
  /// One partial face in a parametrization of its own, where no projection serves; else as partial.
  flat,
  /// Faces no view shows: kBlock x kBlock texels each, holding a linear function.
  blocks,
};

/// Edge of an unseen face's block. Its corners are the centres of three of the four texels, so bilinear lookups inside
/// the face read these four texels alone, and they reproduce the linear function exactly.
inline constexpr int kBlock = 2;

/// Texels of a page's edge that must be left within the padding on both sides.
inline constexpr int kLeastRoom = 4;

struct Chart {
  ChartKind kind = ChartKind::plain;
  ViewId view = kNoView;  ///< of the corners' projection; kNoView for blocks
  std::vector<std::uint32_t> faces;
  double origin_x = 0, origin_y = 0;  ///< frame position of the top-left corner of the first texel; integral at scale 1
  double scale = 1;           ///< texels a frame pixel; 1 unless texels are limited or a single face exceeds a page
  int width = 0, height = 0;  ///< texels touched by faces lie in [0, width) x [0, height)
  /// Charts cut from one piece of a photo have the number of the first of them; others their own.
  std::uint32_t piece = 0;

  PixelPoint frame_position(double x, double y) const { return {origin_x + x / scale, origin_y + y / scale}; }
};

struct ChartSet {
  std::vector<Chart> charts;
  std::vector<std::uint32_t> face_chart;  ///< per face
  std::vector<TexelTriangle> corners;     ///< per face, in its chart's texels
  std::size_t filled_faces = 0;
};

/// Neighbours of faces, compressed by face.
struct FaceNeighbours {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> faces;
};

FaceNeighbours face_neighbours(const labeling::FaceGraph& graph, std::size_t faces);

/// Every face lands in exactly one chart whose box, with the padding, fits a page. Charts are ordered by kind and then
/// by their first piece's first face. `reduction` scales all charts below what options.texel_size asks, but for blocks.
/// O(faces log faces + texels of partial faces).
/// \pre options.page_size >= 2 * options.padding + kLeastRoom, 0 < reduction <= 1
ChartSet make_charts(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
                     const CoverageIndex& coverage, double reduction);

}  // namespace gpvc::atlas
