#include "atlas/atlas.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "atlas/baking/bake.h"
#include "atlas/baking/coverage_index.h"
#include "atlas/baking/fill.h"
#include "atlas/baking/pages.h"
#include "atlas/baking/partial.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/seam_leveling.h"
#include "atlas/packing/layout.h"

namespace gpvc::atlas {

struct AtlasPlan::State {
  State(const AtlasInput& input, const AtlasOptions& wanted)
      : options(wanted), coverage(input.coverage), neighbours(face_neighbours(input.graph, input.mesh.faces.size())) {}
  AtlasOptions options;  ///< the page size in whole blocks
  CoverageIndex coverage;
  FaceNeighbours neighbours;
  Layout layout;
  double seconds = 0;
};

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
                     std::span<const Page> pages, io::TexturedModel& model) {
  std::vector<std::vector<std::pair<std::uint32_t, TexelPoint>>> used(set.charts.size());
  tbb::parallel_for(std::size_t{0}, used.size(), [&](std::size_t c) {
    if (set.charts[c].kind == ChartKind::blocks) return;
    auto& mine = used[c];
    for (const auto face : set.charts[c].faces)
      for (std::size_t i = 0; i < 3; ++i) mine.emplace_back(mesh.faces[face][i], set.corners[face][i]);
    const auto before = [](const auto& a, const auto& b) { return a.first < b.first; };
    std::stable_sort(mine.begin(), mine.end(), before);
    mine.erase(std::unique(mine.begin(), mine.end(), [](const auto& a, const auto& b) { return a.first == b.first; }),
               mine.end());
  });
  std::vector<std::size_t> first(used.size() + 1, 0);
  for (std::size_t c = 0; c < used.size(); ++c)
    first[c + 1] =
        first[c] + (set.charts[c].kind == ChartKind::blocks ? 3 * set.charts[c].faces.size() : used[c].size());
  if (first.back() >= 0xFFFFFFFFu) throw std::length_error("more texture coordinates than 32-bit indices reach");
  model.texcoords.resize(first.back());
  model.face_texcoords.resize(mesh.faces.size());
  model.face_page.resize(mesh.faces.size());
  tbb::parallel_for(std::size_t{0}, used.size(), [&](std::size_t c) {
    const Page& page = pages[places[c].page];
    const auto coordinate = [&](const TexelPoint& p) {
      const TexelPoint q = places[c].point(p);
      return io::TexCoord{static_cast<float>(q.x / page.image.width), static_cast<float>(q.y / page.image.height)};
    };
    for (std::size_t i = 0; i < used[c].size(); ++i) model.texcoords[first[c] + i] = coordinate(used[c][i].second);
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

void check(const AtlasInput& input, const AtlasOptions& options) {
  const std::size_t faces = input.mesh.faces.size();
  if (input.labels.size() != faces || input.tags.size() != faces)
    throw std::invalid_argument("labels and tags must have one entry per face");
  if (options.padding < 0) throw std::invalid_argument("padding must not be negative");
  if (options.page_size < 2 * options.padding + kLeastRoom)
    throw std::invalid_argument("page size leaves no room within the padding");
  if (!(options.texel_size >= 0)) throw std::invalid_argument("texel size must not be negative");
}

std::size_t seam_edges(const AtlasInput& input) {
  std::size_t count = 0;
  for (const auto& edge : input.graph.edges) {
    const ViewId a = input.labels[edge[0]], b = input.labels[edge[1]];
    if (a != b && a != kNoView && b != kNoView) ++count;
  }
  return count;
}

}  // namespace

TextureAtlas bake_atlas(const AtlasPlan& plan, const AtlasInput& input, const Progress& progress) {
  const AtlasPlan::State& state = plan.state();
  const AtlasOptions& options = state.options;
  const ChartSet& set = state.layout.set;
  const int edge = block_edge(options.padding);
  TextureAtlas atlas;
  AtlasStatistics& statistics = atlas.statistics;
  atlas.model.mesh = &input.mesh;
  statistics.charts = set.charts.size();
  statistics.filled_faces = set.filled_faces;
  statistics.reduction = state.layout.reduction;
  statistics.layout_s = state.seconds;
  statistics.seam_edges = seam_edges(input);
  Stopwatch watch;

  const LevelingResult leveling = level_seams(input, set, state.coverage, options.seams);
  statistics.seam_step_before = leveling.step_before;
  statistics.seam_step_after = leveling.step_after;
  statistics.leveling_s = watch.lap();

  const auto places = chart_places(state.layout.shapes, state.layout.packing, edge);
  std::vector<Page> pages = make_pages(state.layout.shapes, state.layout.packing, edge);
  auto parts = choose_sources(input, set, state.coverage, options.margin_px);
  bake_photos(input, set, places, leveling.correction, options.padding, pages, parts, progress);
  finish_partial(parts, input, set, state.neighbours, places, options.padding, pages);
  parts.clear();
  if (options.unseen == UnseenFaces::color)
    paint_unseen(set, places, options.unseen_color, pages);
  else
    fill_unseen(input, set, places, pages);
  for (Page& page : pages) {
    statistics.page_texels += page.state.size();
    statistics.chart_texels +=
        static_cast<std::size_t>(std::count(page.state.begin(), page.state.end(), TexelState::chart));
    statistics.padded_texels += pad_charts(page, options.padding);
    fill_background(page);
  }
  write_texcoords(input.mesh, set, places, pages, atlas.model);
  for (Page& page : pages) atlas.pages.push_back(std::move(page.image));
  statistics.baking_s = watch.lap();
  return atlas;
}

AtlasPlan plan_atlas(const AtlasInput& input, const AtlasOptions& options) {
  check(input, options);
  Stopwatch watch;
  auto state = std::make_unique<AtlasPlan::State>(input, options);
  const int edge = block_edge(options.padding);
  state->options.page_size = options.page_size / edge * edge;
  state->layout = lay_out(input, state->options, state->neighbours, state->coverage);
  state->seconds = watch.lap();
  return AtlasPlan(std::move(state));
}

struct TextureOrigins::State {
  const AtlasPlan::State& plan;
  std::vector<PartialChart> parts;
  std::vector<std::uint32_t> part_of;  ///< per chart; those that are not pieced together have none
};

TextureOrigins::TextureOrigins(const AtlasPlan& plan, const AtlasInput& input)
    : state_(new State{plan.state(), {}, {}}) {
  const AtlasPlan::State& state = plan.state();
  const ChartSet& set = state.layout.set;
  state_->parts = choose_sources(input, set, state.coverage, state.options.margin_px);
  state_->part_of.assign(set.charts.size(), 0);
  for (std::uint32_t p = 0; p < state_->parts.size(); ++p) state_->part_of[state_->parts[p].chart] = p;
}

TextureOrigins::~TextureOrigins() = default;

PointOrigin TextureOrigins::at(FaceId face, double b, double c) const {
  const ChartSet& set = state_->plan.layout.set;
  const std::uint32_t number = set.face_chart[index(face)];
  const Chart& chart = set.charts[number];
  const TexelTriangle& t = set.corners[index(face)];
  const double a = 1 - b - c;
  const TexelPoint p{a * t[0].x + b * t[1].x + c * t[2].x, a * t[0].y + b * t[1].y + c * t[2].y};
  switch (chart.kind) {
    case ChartKind::plain:
      return {chart.view, chart.frame_position(p.x, p.y), kNoView, {}, 0};
    case ChartKind::blocks:
      return {};
    default:
      return origin_at(state_->parts[state_->part_of[number]], p);
  }
}

TextureAtlas build_atlas(const AtlasInput& input, const AtlasOptions& options, const Progress& progress) {
  return bake_atlas(plan_atlas(input, options), input, progress);
}

AtlasPlan::AtlasPlan(std::unique_ptr<State> state) : state_(std::move(state)) {}
AtlasPlan::~AtlasPlan() = default;
AtlasPlan::AtlasPlan(AtlasPlan&&) noexcept = default;

AtlasEstimate AtlasPlan::estimate() const {
  const Layout& layout = state_->layout;
  return {layout.set.charts.size(), layout.packing.pages.size(),
          page_texels(layout.packing, block_edge(state_->options.padding)), layout.reduction};
}

}  // namespace gpvc::atlas
