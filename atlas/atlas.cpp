#include "atlas/atlas.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "atlas/bake.h"
#include "atlas/charts.h"
#include "atlas/coverage_index.h"
#include "atlas/fill.h"
#include "atlas/packing.h"
#include "atlas/pages.h"
#include "atlas/partial.h"
#include "atlas/seam_leveling.h"

namespace gpvc {

namespace {

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Faces of a chart share the texture coordinates of the vertices they share.
void write_texcoords(const Mesh& mesh, const ChartSet& set, std::span<const ChartPlace> places,
                     std::span<const Page> pages, TexturedModel& model) {
  std::vector<std::vector<std::pair<std::uint32_t, TexelPoint>>> used(set.charts.size());
  tbb::parallel_for(std::size_t{0}, used.size(), [&](std::size_t c) {
    if (set.charts[c].kind == ChartKind::blocks) return;
    auto& mine = used[c];
    for (const auto face : set.charts[c].faces)
      for (std::size_t i = 0; i < 3; ++i) mine.emplace_back(mesh.faces[face][i], set.corners[face][i]);
    const auto before = [](const auto& a, const auto& b) { return a.first < b.first; };
    std::stable_sort(mine.begin(), mine.end(), before);
    mine.erase(std::unique(mine.begin(), mine.end(),
                           [](const auto& a, const auto& b) { return a.first == b.first; }),
               mine.end());
  });
  std::vector<std::size_t> first(used.size() + 1, 0);
  for (std::size_t c = 0; c < used.size(); ++c)
    first[c + 1] = first[c] + (set.charts[c].kind == ChartKind::blocks ? 3 * set.charts[c].faces.size()
                                                                       : used[c].size());
  if (first.back() >= 0xFFFFFFFFu)
    throw std::length_error("more texture coordinates than 32-bit indices reach");
  model.texcoords.resize(first.back());
  model.face_texcoords.resize(mesh.faces.size());
  model.face_page.resize(mesh.faces.size());
  tbb::parallel_for(std::size_t{0}, used.size(), [&](std::size_t c) {
    const Page& page = pages[places[c].page];
    const auto coordinate = [&](const TexelPoint& p) {
      const TexelPoint q = places[c].point(p);
      return TexCoord{static_cast<float>(q.x / page.image.width),
                      static_cast<float>(q.y / page.image.height)};
    };
    for (std::size_t i = 0; i < used[c].size(); ++i)
      model.texcoords[first[c] + i] = coordinate(used[c][i].second);
    std::size_t next = first[c];
    for (const auto face : set.charts[c].faces) {
      model.face_page[face] = places[c].page;
      for (std::size_t i = 0; i < 3; ++i) {
        std::size_t at = next;
        if (set.charts[c].kind == ChartKind::blocks) {
          model.texcoords[next++] = coordinate(set.corners[face][i]);
        } else {
          const auto found = std::lower_bound(used[c].begin(), used[c].end(), mesh.faces[face][i],
                                              [](const auto& a, std::uint32_t v) { return a.first < v; });
          at = first[c] + static_cast<std::size_t>(found - used[c].begin());
        }
        model.face_texcoords[face][i] = static_cast<std::uint32_t>(at);
      }
    }
  });
}

void count_texels(std::span<const Page> pages, AtlasStatistics& statistics) {
  for (const Page& page : pages) {
    statistics.page_texels += page.state.size();
    statistics.chart_texels +=
        static_cast<std::size_t>(std::count(page.state.begin(), page.state.end(), TexelState::chart));
  }
}

void check(const AtlasInput& input, const AtlasOptions& options) {
  const std::size_t faces = input.mesh.faces.size();
  if (input.labels.size() != faces || input.tags.size() != faces)
    throw std::invalid_argument("labels and tags must have one entry per face");
  if (options.padding < 0) throw std::invalid_argument("padding must not be negative");
  if (options.page_size / kCell * kCell < 2 * options.padding + kLeastRoom)
    throw std::invalid_argument("page size leaves no room within the padding");
}

}  // namespace

TextureAtlas build_atlas(const AtlasInput& input, const AtlasOptions& wanted, const Progress& progress) {
  check(input, wanted);
  AtlasOptions options = wanted;
  options.page_size = wanted.page_size / kCell * kCell;
  TextureAtlas atlas;
  AtlasStatistics& statistics = atlas.statistics;
  atlas.model.mesh = &input.mesh;
  Stopwatch watch;

  const CoverageIndex coverage(input.coverage);
  const FaceNeighbours neighbours = face_neighbours(input.graph, input.mesh.faces.size());
  const ChartSet set = make_charts(input, options, neighbours, coverage);
  const Packing packing = pack_shapes(pack_shapes_of(set, options.padding), options.page_size);
  const std::vector<ChartPlace> places = chart_places(set.charts, packing, options.padding);
  std::vector<Page> pages(packing.pages.begin(), packing.pages.end());
  statistics.charts = set.charts.size();
  statistics.filled_faces = set.filled_faces;
  statistics.layout_s = watch.lap();

  for (const auto& edge : input.graph.edges) {
    const ViewId a = input.labels[edge[0]], b = input.labels[edge[1]];
    if (a != b && a != kNoView && b != kNoView) ++statistics.seam_edges;
  }
  const LevelingResult leveling = level_seams(input, set, coverage, options.seams);
  statistics.seam_step_before = leveling.step_before;
  statistics.seam_step_after = leveling.step_after;
  statistics.leveling_s = watch.lap();

  auto parts = choose_sources(input, set, coverage, options.margin_px);
  bake_photos(input, set, places, leveling.correction, options.padding, pages, parts, progress);
  finish_partial(parts, input, set, neighbours, places, options.padding, pages);
  parts.clear();
  fill_unseen(input, set, places, pages);
  count_texels(pages, statistics);
  for (Page& page : pages) {
    pad_charts(page, options.padding);
    fill_background(page);
  }
  write_texcoords(input.mesh, set, places, pages, atlas.model);
  for (Page& page : pages) atlas.pages.push_back(std::move(page.image));
  statistics.baking_s = watch.lap();
  return atlas;
}

}  // namespace gpvc
