#include "atlas/atlas.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>

#include "atlas/baking/baking.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/seam_leveling.h"
#include "atlas/packing/layout.h"
#include "io/clock.h"

namespace gpvc::atlas {

struct AtlasPlan::State {
  State(const AtlasInput& input, const AtlasOptions& wanted)
      : options(wanted),
        coverage(input.coverage),
        neighbours(group_neighbours(input.mesh.faces.size(), input.graph.edges)) {}
  AtlasOptions options;  ///< the page size rounded down to whole blocks
  CoverageIndex coverage;
  FaceNeighbours neighbours;
  Layout layout;
  double seconds = 0;
};

namespace {

/// A vertex with its position in a chart's texels.
struct ChartVertex {
  std::uint32_t vertex;
  TexelPoint at;
};

/// A projected chart's vertices, each once, in ascending order: its faces share them. A chart of unseen faces has all
/// corners, in the order of its faces.
std::vector<ChartVertex> chart_vertices(const Mesh& mesh, const ChartSet& set, const Chart& chart) {
  std::vector<ChartVertex> list;
  for (const auto face : chart.faces)
    for (std::size_t i = 0; i < 3; ++i) list.push_back({mesh.faces[face][i], set.corners[face][i]});
  if (chart.kind == ChartKind::unseen) return list;
  std::ranges::stable_sort(list, {}, &ChartVertex::vertex);
  list.erase(std::unique(list.begin(), list.end(),
                         [](const ChartVertex& a, const ChartVertex& b) { return a.vertex == b.vertex; }),
             list.end());
  return list;
}

std::size_t find_vertex(std::span<const ChartVertex> list, std::uint32_t vertex) {
  return static_cast<std::size_t>(std::ranges::lower_bound(list, vertex, {}, &ChartVertex::vertex) - list.begin());
}

void write_texcoords(const AtlasBuild& build, io::TexturedModel& model) {
  const Mesh& mesh = build.input.mesh;
  const std::span charts = std::span(build.set.charts).first(build.set.placed);
  std::vector<std::vector<ChartVertex>> vertices(charts.size());
  tbb::parallel_for(std::size_t{0}, charts.size(),
                    [&](std::size_t c) { vertices[c] = chart_vertices(mesh, build.set, charts[c]); });
  std::vector<std::size_t> first(charts.size() + 1, 0);
  for (std::size_t c = 0; c < charts.size(); ++c) first[c + 1] = first[c] + vertices[c].size();
  if (first.back() >= 0xFFFFFFFFu) throw std::length_error("more texture coordinates than 32-bit indices can address");
  model.texcoords.resize(first.back());
  model.face_texcoords.resize(mesh.faces.size());
  model.face_page.assign(mesh.faces.size(), io::kNoPage);
  tbb::parallel_for(std::size_t{0}, charts.size(), [&](std::size_t c) {
    const ChartPlace& place = build.places[c];
    const Image& image = build.pages[place.page].image;
    for (std::size_t i = 0; i < vertices[c].size(); ++i) {
      const TexelPoint q = place.point(vertices[c][i].at);
      model.texcoords[first[c] + i] = {static_cast<float>(q.x / image.width), static_cast<float>(q.y / image.height)};
    }
    std::size_t corner = 0;
    for (const auto face : charts[c].faces) {
      model.face_page[face] = place.page;
      for (std::size_t i = 0; i < 3; ++i, ++corner) {
        const bool shared = charts[c].kind != ChartKind::unseen;
        const std::size_t at = shared ? find_vertex(vertices[c], mesh.faces[face][i]) : corner;
        model.face_texcoords[face][i] = static_cast<std::uint32_t>(first[c] + at);
      }
    }
  });
}

void check(const AtlasInput& input, const AtlasOptions& options) {
  const std::size_t faces = input.mesh.faces.size();
  if (input.labels.size() != faces || input.tags.size() != faces)
    throw std::invalid_argument("labels and tags must have one entry per face");
  if (!input.border.empty() && input.border.size() != faces)
    throw std::invalid_argument("border must be empty or have one entry per face");
  if (!input.exposure.empty() && input.exposure.size() != input.scene.views.size())
    throw std::invalid_argument("exposure must be empty or have one entry per view");
  if (options.padding < 0) throw std::invalid_argument("padding must not be negative");
  if (options.page_size < 2 * options.padding + kLeastRoom)
    throw std::invalid_argument("page size leaves no room within the padding");
  if (!(options.texel_size >= 0)) throw std::invalid_argument("texel size must not be negative");
}

/// Pages [first, end).
struct PageGroup {
  std::uint32_t first = 0, end = 0;
};

/// The first page with a chart that takes colours from charts beside it; the last page if there is none.
std::uint32_t first_last_page(const AtlasBuild& build) {
  auto first = static_cast<std::uint32_t>(build.pages.size()) - 1;
  for (std::size_t c = 0; c < build.set.placed; ++c)
    if (build.set.charts[c].kind != ChartKind::plain) first = std::min(first, build.places[c].page);
  return first;
}

/// Consecutive pages that fit `bytes` together. Packing has put the charts that take colours from others on the last
/// pages.
std::vector<PageGroup> page_groups(const AtlasBuild& build, std::size_t bytes) {
  const auto count = static_cast<std::uint32_t>(build.pages.size());
  std::size_t all = 0;
  for (const Page& page : build.pages) all += page.bytes();
  if (count < 2 || all <= bytes) return {{0, count}};
  const std::uint32_t last = first_last_page(build);
  std::vector<PageGroup> groups;
  std::size_t left = 0;
  for (std::uint32_t p = 0; p < last; ++p) {
    if (build.pages[p].bytes() > left) {
      groups.push_back({p, p});
      left = std::max(bytes, build.pages[p].bytes());
    }
    left -= build.pages[p].bytes();
    groups.back().end = p + 1;
  }
  groups.push_back({last, count});
  return groups;
}

/// Partial charts that are baked together: texels and sources of all of them may take more memory than the pages. There
/// is one batch at least, as plain charts are baked with the first.
std::vector<std::vector<std::uint32_t>> partial_batches(const AtlasBuild& build, std::size_t bytes) {
  // PartialChart has 24 bytes for each texel of a chart's box, and for each face a TexelSource a view, of some eight.
  constexpr std::size_t kTexel = 24, kSources = 8 * sizeof(TexelSource);
  std::vector<std::vector<std::uint32_t>> batches(1);
  std::size_t taken = 0;
  for (const std::uint32_t c : partial_charts(build.set)) {
    const Chart& chart = build.set.charts[c];
    const CellBox box = partial_box(chart);
    const std::size_t chart_bytes =
        kTexel * pixel_index(0, box.y1 - box.y0, box.x1 - box.x0) + kSources * chart.faces.size();
    if (taken > 0 && taken + chart_bytes > bytes) {
      batches.emplace_back();
      taken = 0;
    }
    taken += chart_bytes;
    batches.back().push_back(c);
  }
  return batches;
}

/// Bakes pages group by group.
class PageBaker {
 public:
  PageBaker(AtlasBuild& build, const BakeOptions& options, TextureAtlas& atlas)
      : build_(build),
        options_(options),
        atlas_(atlas),
        groups_(page_groups(build, options.page_bytes)),
        batches_(partial_batches(build, options.partial_bytes)) {
    build_.first_last_page = groups_.back().first;
    if (!options_.take_page) atlas_.pages.resize(build_.pages.size());
  }

  void bake(const Progress& progress) {
    if (groups_.size() > 1) {
      want_beside_partial(build_);
      want_at_holes(build_);
    }
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      for (std::uint32_t p = groups_[g].first; p < groups_[g].end; ++p) build_.pages[p].open();
      if (g + 1 < groups_.size())
        bake_early(groups_[g], progress);
      else
        bake_last(progress);
      tbb::parallel_for(groups_[g].first, groups_[g].end, [&](std::uint32_t p) { finish(p); });
    }
  }

 private:
  /// One pass over the photos. Each counts as a hundred, unless there is only one pass.
  void pass(PlainCharts plain, std::span<PartialChart> partial, const Progress& progress) {
    const std::size_t passes = groups_.size() - 1 + batches_.size(), number = passed_++;
    const Progress part = [&progress, number, passes](std::size_t done, std::size_t total) {
      progress(100 * number + 100 * done / std::max<std::size_t>(total, 1), 100 * passes);
    };
    const PhotoOrder order = number % 2 == 0 ? PhotoOrder::ascending : PhotoOrder::descending;
    bake_photos(build_, plain, partial, order, passes == 1 || !progress ? progress : part);
  }

  void bake_early(const PageGroup& group, const Progress& progress) {
    pass(PlainCharts::bake, {}, progress);
    for (std::uint32_t p = group.first; p < group.end; ++p) {
      keep_beside_partial(build_, p);
      keep_at_holes(build_, p);
      build_.early_mean.add(build_.pages[p]);
    }
  }

  void bake_last(const Progress& progress) {
    std::vector<OpenChart> open;
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      std::vector<PartialChart> partial =
          choose_sources(build_.input, build_.set, build_.coverage, build_.options.margin_px, batches_[b]);
      pass(b == 0 ? PlainCharts::bake : PlainCharts::skip, partial, progress);
      for (OpenChart& chart : write_known(partial, build_)) open.push_back(std::move(chart));
    }
    fill_partial(std::move(open), build_);
    if (build_.options.unseen == UnseenFaces::color)
      paint_unseen(build_);
    else
      fill_unseen(build_);
  }

  void finish(std::uint32_t number) {
    Page& page = build_.pages[number];
    const auto inside = std::count(page.state.begin(), page.state.end(), TexelState::chart);
    const std::size_t padded = pad_charts(page, build_.options.padding);
    {
      const std::lock_guard lock(mutex_);
      atlas_.statistics.page_texels += page.texels();
      atlas_.statistics.chart_texels += static_cast<std::size_t>(inside);
      atlas_.statistics.padded_texels += padded;
    }
    fill_background(page);
    if (options_.take_page)
      options_.take_page(number, page.close());
    else
      atlas_.pages[number] = page.close();
  }

  AtlasBuild& build_;
  const BakeOptions& options_;
  TextureAtlas& atlas_;
  std::vector<PageGroup> groups_;
  std::vector<std::vector<std::uint32_t>> batches_;
  std::size_t passed_ = 0;  ///< passes begun
  std::mutex mutex_;
};

}  // namespace

TextureAtlas bake_atlas(const AtlasPlan& plan, const AtlasInput& input, const Progress& progress,
                        const BakeOptions& options) {
  const AtlasPlan::State& state = plan.state();
  const Layout& layout = state.layout;
  TextureAtlas atlas;
  AtlasStatistics& statistics = atlas.statistics;
  statistics.charts = layout.set.placed;
  statistics.pages = layout.packing.pages.size();
  statistics.filled_faces = layout.set.unseen_faces;
  statistics.reduction = layout.reduction;
  statistics.layout_s = state.seconds;
  for (const auto& [a, b] : input.graph.edges)
    if (input.labels[a] != input.labels[b] && input.labels[a] != kNoView && input.labels[b] != kNoView)
      ++statistics.seam_edges;

  const int edge = block_edge(state.options.padding);
  AtlasBuild build{input,
                   state.options,
                   state.coverage,
                   state.neighbours,
                   layout.set,
                   {},
                   chart_places(layout.shapes, layout.packing, edge),
                   make_pages(layout.shapes, layout.packing, edge)};
  atlas.model.mesh = &input.mesh;
  write_texcoords(build, atlas.model);
  std::future<void> beside;
  if (options.take_model) beside = options.take_model(atlas.model);

  Clock::time_point start = Clock::now();
  LevelingResult leveling = level_seams(input, layout.set, state.coverage, state.options.seams);
  statistics.seam_step_before = leveling.step_before;
  statistics.seam_step_after = leveling.step_after;
  statistics.leveling_s = seconds_since(start);

  start = Clock::now();
  build.correction = std::move(leveling.correction);
  if (!build.pages.empty()) PageBaker(build, options, atlas).bake(progress);
  if (beside.valid()) beside.get();
  statistics.baking_s = seconds_since(start);
  return atlas;
}

AtlasPlan plan_atlas(const AtlasInput& input, const AtlasOptions& options) {
  check(input, options);
  const Clock::time_point start = Clock::now();
  auto state = std::make_shared<AtlasPlan::State>(input, options);
  const int edge = block_edge(options.padding);
  state->options.page_size = options.page_size / edge * edge;
  state->layout = lay_out(input, state->options, state->neighbours, state->coverage);
  state->seconds = seconds_since(start);
  return AtlasPlan(std::move(state));
}

struct TextureOrigins::State {
  const AtlasPlan::State& plan;
  std::vector<PartialChart> parts;  ///< by chart
};

TextureOrigins::TextureOrigins(const AtlasPlan& plan, const AtlasInput& input) {
  const AtlasPlan::State& made = plan.state();
  state_ =
      std::make_shared<State>(State{made, choose_sources(input, made.layout.set, made.coverage, made.options.margin_px,
                                                         partial_charts(made.layout.set))});
}

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
    case ChartKind::unseen:
    case ChartKind::border:
      return {};
    default:
      return origin_at(*std::ranges::lower_bound(state_->parts, number, {}, &PartialChart::chart), p);
  }
}

std::size_t photos_held() { return 1 + photos_ahead(); }

TextureAtlas build_atlas(const AtlasInput& input, const AtlasOptions& options, const Progress& progress) {
  return bake_atlas(plan_atlas(input, options), input, progress);
}

AtlasEstimate AtlasPlan::estimate() const {
  const Layout& layout = state_->layout;
  return {layout.set.placed, layout.packing.pages.size(),
          page_texels(layout.packing, block_edge(state_->options.padding)), layout.reduction};
}

}  // namespace gpvc::atlas
