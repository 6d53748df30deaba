#include "atlas/alignment/cut_places.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <utility>

#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// Edge, in pixels, of the squares of a frame that have one place a pair of views: half of what a patch compares.
constexpr double kSpacing = kPatchWindow * io::kCoarsePixel / 2.0;
/// So many places tell the 90th percentile to half a per cent of the places; they take 20 MB.
constexpr std::size_t kMostCutPlaces = 4096;

struct CutPlace {
  std::array<std::uint32_t, 2> views;
  std::int32_t row, column;
  std::uint32_t edge;  ///< of the graph
  PixelPoint at;
  auto square() const { return std::tuple(views, row, column); }
};

std::optional<CutPlace> place_on(const AtlasInput& input, std::uint32_t edge) {
  const auto& [a, b] = input.graph.edges[edge];
  const auto is_textured = [&](std::uint32_t face) {
    return input.labels[face] != kNoView && input.tags[face] == labeling::FaceTag::seen;
  };
  const auto is_in_border = [&](std::uint32_t face) { return !input.border.empty() && input.border[face] != 0; };
  if (input.labels[a] == input.labels[b] || !is_textured(a) || !is_textured(b)) return std::nullopt;
  if (is_in_border(std::min(a, b)) || (input.finished != nullptr && is_in_border(std::max(a, b)))) return std::nullopt;
  const auto vertices = shared_edge(input.mesh.faces[a], input.mesh.faces[b]);
  if (!vertices) return std::nullopt;
  const auto first = static_cast<std::uint32_t>(index(input.labels[a]));
  const auto second = static_cast<std::uint32_t>(index(input.labels[b]));
  const View& reference = input.scene.views[std::min(first, second)];
  const WorldPoint middle = 0.5 * (input.mesh.positions[(*vertices)[0]] + input.mesh.positions[(*vertices)[1]]);
  const auto at = pixel_from_world(reference, middle);
  if (!at || !is_in_frame(reference.camera, *at)) return std::nullopt;
  return CutPlace{{std::min(first, second), std::max(first, second)},
                  static_cast<std::int32_t>(at->y / kSpacing),
                  static_cast<std::int32_t>(at->x / kSpacing),
                  edge,
                  *at};
}

}  // namespace

CutPlaces cut_places(const AtlasInput& input, const FaceNeighbours& neighbours) {
  std::vector<CutPlace> found;
  for (std::uint32_t e = 0; e < input.graph.edges.size(); ++e)
    if (const auto one = place_on(input, e)) found.push_back(*one);
  std::ranges::sort(found, {}, [](const CutPlace& f) { return std::tuple(f.square(), f.edge); });
  const auto same = [](const CutPlace& a, const CutPlace& b) { return a.square() == b.square(); };
  found.erase(std::unique(found.begin(), found.end(), same), found.end());
  CutPlaces cuts;
  const std::size_t stride = found.size() / kMostCutPlaces + 1;
  for (std::size_t i = 0; i < found.size(); i += stride) {
    const CutPlace& one = found[i];
    cuts.places.push_back({{ViewId{one.views[0]}, one.at, input.graph.edges[one.edge][0]}, {ViewId{one.views[1]}}, 1});
  }
  cuts.surfaces = find_surfaces(input, neighbours, cuts.places);
  return cuts;
}

}  // namespace gpvc::atlas
