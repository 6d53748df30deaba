#include "atlas/atlas.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "atlas/alignment/alignment.h"
#include "atlas/baking/kept_pages.h"
#include "atlas/baking/page_baker.h"
#include "atlas/charts/charts.h"
#include "atlas/charts/layout.h"
#include "atlas/leveling/band_gains.h"
#include "atlas/leveling/seam_leveling.h"
#include "io/clock.h"
#include "io/freed_memory.h"
#include "io/vector.h"

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

/// Numbers the texture coordinates of a chart's faces, from 0 on, and returns where they lie in its texels. A projected chart has one for
/// each vertex, in ascending order: its faces share them. A chart of unseen faces has all corners, in the order of its faces.
std::vector<TexelPoint> number_texcoords(const Mesh& mesh, const ChartSet& set, const Chart& chart,
                                         std::vector<Triangle>& face_texcoords) {
  constexpr unsigned kBits = 32;
  std::vector<std::uint64_t> corners;  // the vertex, and the number among the corners of all faces
  corners.reserve(3 * chart.faces.size());
  for (const auto face : chart.faces)
    for (const std::uint32_t vertex : mesh.faces[face])
      corners.push_back(std::uint64_t{vertex} << kBits | corners.size());
  const bool are_shared = chart.kind != ChartKind::unseen;
  if (are_shared) std::ranges::sort(corners);
  std::vector<TexelPoint> at;
  std::uint64_t before = 0;
  for (const std::uint64_t corner : corners) {
    const std::size_t number = corner & 0xFFFFFFFFu, face = chart.faces[number / 3];
    if (!are_shared || at.empty() || corner >> kBits != before >> kBits) at.push_back(set.corners[face][number % 3]);
    before = corner;
    face_texcoords[face][number % 3] = static_cast<std::uint32_t>(at.size() - 1);
  }
  return at;
}

void take_layout(const AtlasInput& input, io::TexturedModel& model) {
  const io::UvLayout& layout = *input.layout;
  model.texcoords = layout.texcoords;
  model.obj_texcoords = layout.obj_texcoords;
  model.face_texcoords = layout.face_texcoords;
  model.face_page = layout.face_page;
  for (std::size_t face = 0; face < input.border.size(); ++face)
    if (input.border[face]) model.face_page[face] = io::kNoPage;
}

void write_texcoords(const AtlasBuild& build, io::TexturedModel& model) {
  if (build.input.layout != nullptr) return take_layout(build.input, model);
  const Mesh& mesh = build.input.mesh;
  const std::span charts = std::span(build.set.charts).first(build.set.placed);
  std::vector<std::vector<TexelPoint>> places(charts.size());
  model.face_texcoords.resize(mesh.faces.size());
  tbb::parallel_for(std::size_t{0}, charts.size(), [&](std::size_t c) {
    places[c] = number_texcoords(mesh, build.set, charts[c], model.face_texcoords);
  });
  std::vector<std::size_t> first(charts.size() + 1, 0);
  for (std::size_t c = 0; c < charts.size(); ++c) first[c + 1] = first[c] + places[c].size();
  if (first.back() >= 0xFFFFFFFFu) throw std::length_error("more texture coordinates than 32-bit indices can address");
  model.texcoords.resize(first.back());
  model.face_page.assign(mesh.faces.size(), io::kNoPage);
  tbb::parallel_for(std::size_t{0}, charts.size(), [&](std::size_t c) {
    const ChartPlace& place = build.places[c];
    const Image& image = build.pages[place.page].image;
    for (std::size_t i = 0; i < places[c].size(); ++i) {
      const TexelPoint q = place.point(places[c][i]);
      model.texcoords[first[c] + i] = {static_cast<float>(q.x / image.width), static_cast<float>(q.y / image.height)};
    }
    for (const auto face : charts[c].faces) {
      model.face_page[face] = place.page;
      for (std::uint32_t& texcoord : model.face_texcoords[face]) texcoord += static_cast<std::uint32_t>(first[c]);
    }
  });
}

/// The size that pages get: whole blocks.
int whole_blocks(int page_size, int padding) { return page_size - page_size % block_edge(padding); }

void check(const AtlasInput& input, const AtlasOptions& options) {
  const std::size_t faces = input.mesh.faces.size();
  if (input.labels.size() != faces || input.tags.size() != faces)
    throw std::invalid_argument("labels and tags must have one entry per face");
  if (input.candidates.faces() != faces) throw std::invalid_argument("candidates must have one entry per face");
  if (!input.border.empty() && input.border.size() != faces)
    throw std::invalid_argument("border must be empty or have one entry per face");
  if (input.finished != nullptr && input.border.empty())
    throw std::invalid_argument("faces with a finished texture must be given as the border");
  if (!input.tile.empty() && input.tile.size() != faces)
    throw std::invalid_argument("tile must be empty or have one entry per face");
  if (!input.exposure.empty() && input.exposure.size() != input.scene.views.size())
    throw std::invalid_argument("exposure must be empty or have one entry per view");
  if (!input.alignment.empty() && input.alignment.size() != input.scene.views.size())
    throw std::invalid_argument("alignment must be empty or have one field per view");
  if (!std::ranges::all_of(input.alignment, [](const ShiftField& field) { return is_sound(field); }))
    throw std::invalid_argument("alignment must have shifts of up to 16 pixels at all nodes of its fields");
  if (!std::ranges::all_of(input.exposure, [](const ViewExposure& exposure) { return is_sound(exposure); }))
    throw std::invalid_argument("exposure must have finite numbers, and gains above 0 and up to 2.5");
  if (input.layout != nullptr) {
    check_layout(input.mesh, *input.layout);
    if (!input.tile.empty() || input.finished != nullptr)
      throw std::invalid_argument("a layout excludes tiles and a finished texture");
    if (options.max_pages > 0 || options.max_texels > 0 || options.texel_size > 0)
      throw std::invalid_argument("a layout has its own pages and texels, which no limits reduce");
  }
  if (options.padding < 0) throw std::invalid_argument("padding must not be negative");
  if (whole_blocks(options.page_size, options.padding) < 2 * options.padding + kLeastRoom)
    throw std::invalid_argument("page size leaves no room within the padding");
  if (!(options.texel_size >= 0)) throw std::invalid_argument("texel size must not be negative");
}

std::size_t count_blended(const Mesh& mesh, const BlendWeights& blending) {
  if (blending.empty()) return 0;
  return static_cast<std::size_t>(std::ranges::count_if(mesh.faces, [&](const Triangle& face) {
    return std::ranges::any_of(face, [&](std::uint32_t vertex) { return !blending.at(vertex).empty(); });
  }));
}

AtlasInput with_scene(const AtlasInput& input, const Scene& scene) {
  return {input.mesh,     scene,        input.photos,   input.graph,    input.labels, input.tags,      input.candidates,
          input.coverage, input.border, input.exposure, input.finished, input.tile,   input.alignment, input.layout};
}

}  // namespace

TextureAtlas bake_atlas(const AtlasPlan& plan, const AtlasInput& given, const Progress& progress,
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
  for (const auto& [a, b] : given.graph.edges)
    if (given.labels[a] != given.labels[b] && given.labels[a] != kNoView && given.labels[b] != kNoView)
      ++statistics.seam_edges;

  Clock::time_point start = Clock::now();
  std::size_t decodes = given.photos.decodes().times;
  std::optional<AlignmentFit> alignment = take_alignment(options.kept, given);
  std::optional<LevelingResult> leveling = take_leveling(options.kept, given, layout.set);
  const bool aligns = !alignment && given.alignment.empty() && state.options.align != PhotoAlignment::none;
  const bool levels = !leveling && state.options.seams != SeamLeveling::none;
  CutPlaces cuts;  // needed by both
  if (aligns || levels) cuts = cut_places(given, state.neighbours);
  if (!alignment) {
    // No page is open yet.
    const std::size_t bytes = std::min(options.page_bytes, kMatchBytes);
    alignment = aligns ? fit_alignment(given.scene, match_photos(given, state.neighbours, cuts, bytes))
                       : AlignmentFit{{given.alignment.begin(), given.alignment.end()}, {}};
    keep_alignment(options.kept, *alignment);
  }
  statistics.alignment = alignment->statistics;
  statistics.alignment_s = seconds_since(start);
  const Scene scene = aligned_scene(given.scene, alignment->fields);
  const AtlasInput input = with_scene(given, scene);
  atlas.alignment = std::move(alignment->fields);

  const BlendWeights blending =
      state.options.blend == Blending::none ? BlendWeights() : BlendWeights(input, state.options.blend_cost);
  statistics.blended_faces = count_blended(input.mesh, blending);
  const BandSet* bands = input.scene.bands ? &*input.scene.bands : nullptr;
  AtlasBuild build{input,
                   state.options,
                   state.coverage,
                   state.neighbours,
                   layout.set,
                   blending,
                   {},
                   {bands},
                   chart_places(layout.shapes, layout.packing, layout.edge),
                   input.layout != nullptr ? given_pages(layout.packing, bands)
                                           : make_pages(layout.shapes, layout.packing, layout.edge, bands)};
  atlas.model.mesh = &input.mesh;
  write_texcoords(build, atlas.model);
  std::future<void> beside;
  if (options.take_model) beside = options.take_model(atlas.model);

  start = Clock::now();
  const auto more_decodes = [&] {
    const std::size_t before = std::exchange(decodes, input.photos.decodes().times);
    return decodes - before;
  };
  const bool is_kept = leveling.has_value();
  if (!leveling) leveling = level_seams(input, layout.set, state.coverage, cuts, blending, state.options.seams);
  cuts = {};
  build.correction = std::move(leveling->correction);
  // Written while pages are painted: for hundreds of photos it is more than a gigabyte.
  std::future<void> keeping;
  if (!is_kept)
    keeping =
        std::async(std::launch::async, [&] { keep_leveling(options.kept, build.correction, leveling->statistics); });
  const LevelingStatistics& leveled = leveling->statistics;
  statistics.seam_step_before = leveled.step_before;
  statistics.seam_step_after = leveled.step_after;
  statistics.photo_misfit = leveled.misfit_before;
  statistics.photo_misfit_exposed = leveled.misfit_exposed;
  statistics.cuts = leveled.cuts;
  release_freed_memory();
  statistics.leveling_s = seconds_since(start);
  statistics.seam_decodes = more_decodes();

  start = Clock::now();
  atlas.face_chart = layout.set.face_chart;
  atlas.exposure = build.correction.exposure;
  if (bands != nullptr && bands->radiometric && state.options.band_gains) build.painting.gains = fit_band_gains(input);
  BakedPages baked = bake_pages(build, options, progress);
  atlas.pages = std::move(baked.pages);
  atlas.samples = std::move(baked.samples);
  statistics.page_texels = baked.page_texels;
  statistics.chart_texels = baked.chart_texels;
  statistics.padded_texels = baked.padded_texels;
  statistics.kept_pages = baked.kept_pages;
  statistics.invented_color = baked.invented_color;
  if (keeping.valid()) keeping.get();
  if (beside.valid()) beside.get();
  statistics.baking_s = seconds_since(start);
  statistics.paint_decodes = more_decodes();
  return atlas;
}

AtlasPlan plan_atlas(const AtlasInput& input, const AtlasOptions& options) {
  check(input, options);
  const Clock::time_point start = Clock::now();
  auto state = std::make_shared<AtlasPlan::State>(input, options);
  state->options.page_size = whole_blocks(options.page_size, options.padding);
  state->layout = lay_out(input, state->options, state->neighbours, state->coverage);
  state->seconds = seconds_since(start);
  return AtlasPlan(std::move(state));
}

struct TextureOrigins::State {
  const AtlasPlan::State& plan;
  const AtlasInput& input;
  std::vector<PartialChart> parts;  ///< by chart

  /// Where a view shows a point of a face. \pre it shows all of the face
  PixelPoint position(FaceId face, ViewId id, const std::array<double, 3>& weights) const {
    WorldPoint p;
    for (std::size_t i = 0; i < 3; ++i) p = p + input.mesh.positions[input.mesh.faces[index(face)][i]] * weights[i];
    const View& view = input.scene.views[index(id)];
    return pixel_from_camera(view.camera, camera_from_world(view.pose, p));
  }
};

TextureOrigins::TextureOrigins(const AtlasPlan& plan, const AtlasInput& input) {
  const AtlasPlan::State& made = plan.state();
  state_ = std::make_shared<State>(
      State{made, input,
            choose_sources(input, made.options, made.layout.set, made.coverage, partial_charts(made.layout.set))});
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
      if (chart.given) return {chart.view, state_->position(face, chart.view, {a, b, c}), kNoView, {}, 0};
      return {chart.view, chart.frame_position(p.x, p.y), kNoView, {}, 0};
    case ChartKind::unseen:
    case ChartKind::border:
      return {};
    default:
      return origin_at(*std::ranges::lower_bound(state_->parts, number, {}, &PartialChart::chart), chart, p);
  }
}

std::size_t photos_held() { return 1 + photos_ahead(); }

TextureAtlas build_atlas(const AtlasInput& input, const AtlasOptions& options, const Progress& progress) {
  return bake_atlas(plan_atlas(input, options), input, progress);
}

AtlasEstimate AtlasPlan::estimate() const {
  const Layout& layout = state_->layout;
  return {layout.set.placed, layout.packing.pages.size(), page_texels(layout.packing, layout.edge), layout.reduction};
}

}  // namespace gpvc::atlas
