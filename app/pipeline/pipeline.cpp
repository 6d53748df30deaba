#include "app/pipeline/pipeline.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <future>

#include "app/pipeline/coverage_store.h"
#include "io/clock.h"

namespace gpvc::pipeline {
namespace {

void add_times(const visibility::VisibilityStatistics& one, ViewTimes& sum) {
  sum.render_s += one.render_s;
  sum.build_s += one.build_s;
  sum.upload_s += one.upload_s;
  sum.readback_s += one.readback_s;
  sum.classify_s += one.classify_s;
}

}  // namespace

std::size_t photo_cache_bytes() {
  const auto memory =
      static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGE_SIZE));
  return std::min(memory / 4, std::size_t{1} << 30);
}

labeling::FaceGraph weighed_graph(const Mesh& mesh, const cli::TextureOptions& options, cli::Console& console,
                                  cli::RunRecord& record) {
  cli::Stage adjacency(console, record, "face graph");
  labeling::FaceGraph graph = labeling::face_graph(mesh);
  labeling::weigh_edges(mesh, options.edge_weights, graph);
  adjacency.finish(cli::readable_count(graph.edges.size()) + " edges");
  return graph;
}

SeenScene see_views(const cli::SceneInputData& in, io::PhotoSource& photos, visibility::GraphicsDevice& device,
                    const cli::TextureOptions& options, cli::Console& console, cli::RunRecord& record,
                    const ViewObserver& observe) {
  cli::Stage stage(console, record, "visibility and costs", "views");
  visibility::VisibilityStage visibility(device, in.mesh, options.visibility);
  console.note("drawing: " + visibility.drawing_note());
  console.note("classifier: " + visibility.classifier_note());
  record.counts["drawing"] = visibility.drawing_note();
  record.counts["classifier"] = visibility.classifier_note();
  labeling::CandidateCollector collector(in.mesh, options.costs);
  const auto policy = options.common.threads == 1 ? std::launch::deferred : std::launch::async;
  SeenScene seen;
  CoverageStore coverage;
  ViewTimes& times = seen.times;
  std::array<visibility::ViewVisibility, 2> buffers;  // one is filled while the costs of the other are taken
  std::future<void> costs;
  for (std::size_t n = 0; n < in.used.size(); ++n) {
    stage.progress(n, in.used.size());
    const ViewId id = in.used[n];
    const View& view = in.scene.views[index(id)];
    auto decoded = std::async(policy, [&photos, id] { return photos.photo(id); });
    visibility::ViewVisibility& visible = buffers[n % 2];
    visibility.classify(view, id, visible);
    add_times(visible.statistics, times);
    if (observe) observe(id, visible);
    if (visible.statistics.full + visible.statistics.partial == 0)
      console.warning(fmt::format(
          "{}: sees no face of the mesh: its camera may lie inside the mesh, or its pose be wrong", view.name));
    seen.full += visible.statistics.full;
    seen.partial += visible.statistics.partial;
    coverage.add(visible.coverage);
    if (costs.valid()) costs.get();
    costs = std::async(policy, [&, id, photo = decoded.share()] {
      const auto pixels = photo.get();
      const auto start = Clock::now();
      collector.add_view(id, view, *pixels, visible);
      times.costs_s += seconds_since(start);
    });
  }
  costs.get();
  const auto start = Clock::now();
  seen.candidates = collector.finish();
  times.costs_s += seconds_since(start);
  seen.coverage = coverage.of_partial_faces(seen.candidates.tags);
  for (const auto& [name, value] : {std::pair{"render_s", times.render_s},
                                    {"build_s", times.build_s},
                                    {"upload_s", times.upload_s},
                                    {"readback_s", times.readback_s},
                                    {"classify_s", times.classify_s},
                                    {"costs_s", times.costs_s}})
    stage.add(name, value);
  record.counts["full"] = seen.full;
  record.counts["partial"] = seen.partial;
  record.counts["hidden"] = in.used.size() * in.mesh.faces.size() - seen.full - seen.partial;
  stage.finish(fmt::format("{} views", in.used.size()));
  return seen;
}

void count_tags(const labeling::Candidates& candidates, const std::filesystem::path& mesh, cli::Console& console,
                cli::RunRecord& record) {
  std::array<std::size_t, 3> counts{};
  for (const labeling::FaceTag tag : candidates.tags) ++counts[static_cast<std::size_t>(tag)];
  record.counts["tags"] = {{"seen", counts[0]}, {"partial", counts[1]}, {"filled", counts[2]}};
  record.counts["candidates"] = {
      {"full", candidates.full}, {"partial", candidates.partial}, {"rejected", candidates.rejected}};
  const double total = static_cast<double>(candidates.tags.size());
  console.note(fmt::format("faces: {:.1f} % seen whole by some view, {:.1f} % in parts, {:.1f} % filled",
                           100 * static_cast<double>(counts[0]) / total, 100 * static_cast<double>(counts[1]) / total,
                           100 * static_cast<double>(counts[2]) / total));
  if (counts[0] + counts[1] == 0)
    throw InputError(mesh, "",
                     "no photo sees any face of the mesh: are mesh and cameras in the same coordinates, and the "
                     "cameras outside the mesh?");
  if (20 * (counts[0] + counts[1]) < candidates.tags.size())
    console.warning("photos see less than 5 % of the faces; are mesh and cameras in the same coordinates?");
}

labeling::Selection choose_views(const SeenScene& seen, const labeling::FaceGraph& graph,
                                 const cli::TextureOptions& options, cli::Console& console, cli::RunRecord& record) {
  cli::Stage stage(console, record, "view selection", "sweeps", true);
  labeling::Selection selection =
      labeling::select_views(seen.candidates.table, graph, options.solver, stage.reporter());
  for (const labeling::SweepReport& sweep : selection.sweeps)
    console.detail(fmt::format("  sweep {}: energy {:.1f}, {:.2f} s", sweep.sweep, sweep.energy, sweep.seconds));
  record.counts["energy"] = selection.energy;
  record.counts["differing_pairs"] = selection.differing_pairs;
  record.counts["patches"] = selection.patches;
  record.counts["sweeps"] = selection.sweeps.size();
  stage.finish(fmt::format("{} patches, energy {:.0f}", cli::readable_count(selection.patches), selection.energy));
  return selection;
}

namespace {

// Before photos are read: who finds this too much can stop here and set limits.
void note_estimate(const atlas::AtlasEstimate& e, cli::Console& console) {
  std::string text =
      fmt::format("estimate: {} {} with {:.1f} megatexels in all, {} charts", e.pages, e.pages == 1 ? "page" : "pages",
                  static_cast<double>(e.page_texels) * 1e-6, cli::readable_count(e.charts));
  if (e.reduction < 1) text += fmt::format("; reduced to {:.1f} % to meet the limits", 100 * e.reduction);
  console.note(text);
}

}  // namespace

atlas::TextureAtlas make_atlas(const atlas::AtlasInput& input, const cli::TextureOptions& options,
                               cli::Console& console, cli::RunRecord& record) {
  cli::Stage stage(console, record, "atlas", "steps");
  const atlas::AtlasPlan plan = atlas::plan_atlas(input, options.atlas);
  note_estimate(plan.estimate(), console);
  atlas::TextureAtlas atlas = atlas::bake_atlas(plan, input, stage.reporter());
  const atlas::AtlasStatistics& s = atlas.statistics;
  stage.add("layout_s", s.layout_s);
  stage.add("leveling_s", s.leveling_s);
  stage.add("baking_s", s.baking_s);
  record.counts["charts"] = s.charts;
  record.counts["filled_faces"] = s.filled_faces;
  record.counts["pages"] = atlas.pages.size();
  record.counts["chart_texels"] = s.chart_texels;
  record.counts["padded_texels"] = s.padded_texels;
  record.counts["page_texels"] = s.page_texels;
  record.counts["reduction"] = s.reduction;
  record.counts["seam_edges"] = s.seam_edges;
  // Without leveling nobody looks at the seams: that would decode the photos once more.
  std::string seams;
  if (options.atlas.seams != atlas::SeamLeveling::none) {
    record.counts["seam_step_before"] = s.seam_step_before;
    record.counts["seam_step_after"] = s.seam_step_after;
    seams = fmt::format(", seam step {:.1f} to {:.1f}", s.seam_step_before, s.seam_step_after);
  }
  const double fill = s.page_texels == 0 ? 0 : static_cast<double>(s.chart_texels) / static_cast<double>(s.page_texels);
  stage.finish(fmt::format("{} charts on {} {} ({:.0f} % full){}", cli::readable_count(s.charts), atlas.pages.size(),
                           atlas.pages.size() == 1 ? "page" : "pages", 100 * fill, seams));
  return atlas;
}

}  // namespace gpvc::pipeline
