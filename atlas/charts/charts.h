// Charts: sets of faces that share a piece of a page, and where their corners lie in it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/charts/triangle_spans.h"
#include "atlas/sampling/coverage_index.h"
#include "io/grouping.h"
#include "io/vector.h"

namespace gpvc::atlas {

enum class ChartKind : std::uint8_t {
  /// Fully seen faces of one view, whose photo gives the texels: frame = origin + texel / scale. Connected parts of the
  /// photo whose paddings would overlap share a chart and keep their relative places.
  plain,
  /// Partially seen faces, projected like plain ones. Every texel comes from the best view that shows it, so no texel
  /// centre may lie in two faces.
  partial,
  /// One face whose projection is unusable (charts/flat_chart.h), with a parametrization of its own; otherwise like partial.
  flat,
  /// Faces that no view shows: kUnseenTexels x kUnseenTexels texels each, which hold a linear function.
  unseen,
  /// Connected faces of the border, projected like plain ones, at scale 1 and without a place on a page. Faces whose
  /// projection is unusable have all corners in one point.
  border,
};

/// Edge of the square of texels that an unseen face has. The face's corners are the centres of three of the four
/// texels, so bilinear lookups inside the face read only these four and reproduce the linear function exactly.
inline constexpr int kUnseenTexels = 2;

/// Least edge of a page without the padding on both sides, texels.
inline constexpr int kLeastRoom = 4;

struct Chart {
  ChartKind kind = ChartKind::plain;
  ViewId view = kNoView;   ///< whose projection gives the corners; kNoView for unseen faces
  std::uint32_t tile = 0;  ///< of all its faces, AtlasInput::tile
  /// Its faces lie where AtlasInput::layout has them, rather than where the view shows them: each by an affine map of its own.
  /// The origin is then the page position of the box, at scale 1.
  bool given = false;
  std::vector<std::uint32_t> faces;
  double origin_x = 0, origin_y = 0;  ///< frame position of the top-left corner of the first texel; integral at scale 1
  double scale = 1;           ///< texels a frame pixel; 1 unless texels are limited or a single face exceeds a page
  int width = 0, height = 0;  ///< texels touched by faces lie in [0, width) x [0, height)
  /// Charts cut from one piece of a photo share the number of the first of them; other charts have their own number.
  std::uint32_t piece = 0;
  /// Charts that need the same photos have close ranks: pages ascend by rank, and partial charts are baked in its order.
  std::uint32_t rank = 0;

  PixelPoint frame_position(double x, double y) const { return {origin_x + x / scale, origin_y + y / scale}; }
};

struct ChartSet {
  std::vector<Chart> charts;
  std::size_t placed = 0;                 ///< charts before those of the border
  std::vector<std::uint32_t> face_chart;  ///< per face
  std::vector<TexelTriangle> corners;     ///< per face, in its chart's texels
  std::size_t unseen_faces = 0;
};

/// The face's tile, AtlasInput::tile.
inline std::uint32_t tile_of(const AtlasInput& input, std::size_t face) {
  return input.tile.empty() ? 0 : input.tile[face];
}

/// False for unseen faces.
inline bool has_view(const AtlasInput& input, std::size_t face) {
  return input.labels[face] != kNoView && labeling::has_candidates(input.tags[face]);
}

inline WorldPoint middle_of(const Mesh& mesh, std::uint32_t face) {
  const Triangle& t = mesh.faces[face];
  return (1.0 / 3) * (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]);
}

/// Which of the face's corners the vertex is. \pre one of them is
inline std::size_t corner_of(const Triangle& face, std::uint32_t vertex) {
  return face[0] == vertex ? 0u : face[1] == vertex ? 1u : 2u;
}

/// The faces that share an edge with each face.
using FaceNeighbours = Grouped<std::uint32_t>;

/// Puts every face in exactly one chart, whose box, with the padding, fits a page unless it is of the border. Charts
/// are ordered by kind and then by the first face of their piece. `reduction` scales all charts, except those of unseen
/// faces and of the border, below the density that options.texel_size asks for. O(faces log faces + texels of partial
/// faces). \pre options.page_size >= 2 * options.padding + kLeastRoom, 0 < reduction <= 1
ChartSet make_charts(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
                     const CoverageIndex& coverage, double reduction);

/// The vertices of an edge that both faces have; nullopt for faces that share none or are degenerate.
std::optional<std::array<std::uint32_t, 2>> shared_edge(const Triangle& a, const Triangle& b);

}  // namespace gpvc::atlas
