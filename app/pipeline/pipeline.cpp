#include "app/pipeline/pipeline.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <new>
#include <optional>

#include "app/checks/frame_check.h"
#include "app/pipeline/edit_files.h"
#include "app/pipeline/kept_work.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/texture_files.h"
#include "io/freed_memory.h"

namespace gpvc::pipeline {
namespace {

// Noted before photos are read, so that a user can stop here and set limits.
void note_estimate(const atlas::AtlasEstimate& e, Observer& observer) {
  std::string text =
      fmt::format("estimate: {} {} with {:.1f} megatexels in all, {} charts", e.pages, e.pages == 1 ? "page" : "pages",
                  static_cast<double>(e.page_texels) * 1e-6, results::readable_count(e.charts));
  if (e.reduction < 1) text += fmt::format("; reduced to {:.1f} % to meet the limits", 100 * e.reduction);
  observer.note(text);
}

void report_atlas(const atlas::TextureAtlas& atlas, bool leveled, Observer& observer) {
  const atlas::AtlasStatistics& s = atlas.statistics;
  observer.stage_figure("layout_s", s.layout_s);
  observer.stage_figure("leveling_s", s.leveling_s);
  observer.stage_figure("baking_s", s.baking_s);
  observer.figure("charts", s.charts);
  observer.figure("filled_faces", s.filled_faces);
  observer.figure("pages", s.pages);
  observer.figure("chart_texels", s.chart_texels);
  observer.figure("padded_texels", s.padded_texels);
  observer.figure("page_texels", s.page_texels);
  observer.figure("reduction", s.reduction);
  observer.figure("seam_edges", s.seam_edges);
  std::string seams;
  if (s.kept_pages > 0) {
    observer.figure("kept.pages", s.kept_pages);
    seams = fmt::format(", {} of them kept by an earlier run", s.kept_pages);
  }
  if (leveled) {
    observer.figure("seam_step_before", s.seam_step_before);
    observer.figure("seam_step_after", s.seam_step_after);
    seams += fmt::format(", seam step {:.1f} to {:.1f}", s.seam_step_before, s.seam_step_after);
  }
  const double fill = s.page_texels == 0 ? 0 : static_cast<double>(s.chart_texels) / static_cast<double>(s.page_texels);
  observer.end(fmt::format("{} charts on {} {} ({:.0f} % full){}", results::readable_count(s.charts), s.pages,
                           s.pages == 1 ? "page" : "pages", 100 * fill, seams));
}

}  // namespace

atlas::AtlasPlan plan_and_note(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer) {
  atlas::AtlasPlan made = atlas::plan_atlas(input, options);
  note_estimate(made.estimate(), observer);
  return made;
}

void report_selection(const labeling::Selection& selection, const char* origin, Observer& observer) {
  for (const labeling::SweepReport& sweep : selection.sweeps)
    observer.detail(fmt::format("  sweep {}: energy {:.1f}, {:.2f} s", sweep.sweep, sweep.energy, sweep.seconds));
  observer.figure("energy", selection.energy);
  observer.figure("differing_pairs", selection.differing_pairs);
  observer.figure("patches", selection.patches);
  observer.figure("sweeps", selection.sweeps.size());
  observer.end(
      fmt::format("{} patches, energy {:.0f}{}", results::readable_count(selection.patches), selection.energy, origin));
}

atlas::TextureAtlas bake_and_end(const atlas::AtlasPlan& plan, const atlas::AtlasInput& input,
                                 const atlas::AtlasOptions& options, Observer& observer,
                                 const atlas::BakeOptions& memory) {
  atlas::TextureAtlas atlas = atlas::bake_atlas(plan, input, observer.reporter(), memory);
  report_atlas(atlas, options.seams != atlas::SeamLeveling::none, observer);
  return atlas;
}

atlas::BakeOptions bake_options(const atlas::AtlasPlan& plan, const Settings& settings, const MemoryPlan& memory,
                                io::PhotoSource& photos) {
  constexpr auto kTexel = static_cast<double>(atlas::kPageBytesPerTexel);
  const double pages = kTexel * static_cast<double>(plan.estimate().page_texels);
  const double page = std::min(pages, kTexel * settings.atlas.page_size * settings.atlas.page_size);
  const MemoryPlan::Shares shares = memory.while_painting(pages, page);
  photos.keep_at_most(shares.photos);
  return {.page_bytes = shares.pages, .partial_bytes = shares.partial};
}

namespace {

labeling::Selection take_or_choose(const Choice& choice, const labeling::SolverOptions& options, Observer& observer,
                                   KeptWork* kept) {
  const labeling::CostTable& costs = choice.seen.candidates.table;
  if (kept != nullptr) {
    if (std::optional<labeling::Selection> selection = kept->selection(costs.faces())) {
      observer.begin({"view selection"});
      report_selection(*selection, ", kept by an earlier run", observer);
      return std::move(*selection);
    }
  }
  labeling::Selection selection = choose(costs, choice.graph, options, observer);
  if (kept != nullptr) kept->keep_selection(selection);
  return selection;
}

// How long a run must be expected to take for its work to be kept.
constexpr double kKeepSeconds = 60;

// Where the work of a run is kept, if it is.
std::optional<KeptWork> kept_work(const Input& input, const Settings& settings, const Workload& work,
                                  const FileSizes& sizes, io::PhotoSource& photos, const OutputFolder& folder,
                                  Observer& observer) {
  if (settings.keep_work == KeepWork::never) return std::nullopt;
  const bool earlier = folder.has_kept_work();
  if (settings.keep_work == KeepWork::automatic && !earlier &&
      predicted_seconds(work, tbb::this_task_arena::max_concurrency()) < kKeepSeconds)
    return std::nullopt;
  if (!earlier && folder.space() < sizes.likely + kept_bytes(work)) {
    observer.note(fmt::format(
        "work is not kept, as that might take {} more on disk: if this run is cut off, it starts again from nothing",
        results::readable_bytes(kept_bytes(work))));
    return std::nullopt;
  }
  std::optional<KeptWork> kept = KeptWork::make(folder.kept_work(), input, settings, photos, observer);
  if (kept && !earlier)
    observer.note(
        fmt::format("work is kept in {} until all is done: if this run is cut off, the same command goes on from there",
                    folder.kept_work().string()));
  return kept;
}

}  // namespace

Choice see_and_choose(const Input& input, const Settings& settings, const MemoryPlan& memory, io::PhotoSource& photos,
                      Observer& observer, SeeOptions options) {
  photos.keep_at_most(memory.photos_while_seeing());
  Choice choice{weighed_graph(input.mesh, settings.edge_weights, observer), {}, {}};
  options.graph = &choice.graph;
  choice.seen = see(input, settings, photos, observer, options);
  release_freed_memory();
  choice.selection = take_or_choose(choice, settings.solver, observer, options.kept);
  release_freed_memory();
  return choice;
}

namespace {

TexturedMesh finished(Choice choice, atlas::TextureAtlas atlas) {
  return {std::move(choice.selection), std::move(choice.seen.candidates.tags), std::move(atlas),
          std::move(choice.seen.device)};
}

void note_memory(const MemoryPlan& memory, Observer& observer) {
  const MemoryNeed& need = memory.need;
  observer.detail(fmt::format("memory: up to {}; needed at least are {} to see, {} to choose, {} to paint, {} to write",
                              results::readable_bytes(memory.limit), results::readable_bytes(need.seeing),
                              results::readable_bytes(need.choosing), results::readable_bytes(need.painting),
                              results::readable_bytes(need.writing)));
}

TexturedFiles texture_within(const MemoryPlan& memory, const Input& input, const Settings& settings,
                             io::PhotoSource& photos, OutputFolder& folder, Observer& observer) {
  note_memory(memory, observer);
  FileSizes sizes = predicted_sizes(input, settings, memory.work.texels);
  if (settings.editable) sizes.likely += edit_bytes(memory.work);
  folder.expect_space(sizes.least, sizes.likely, observer);
  std::optional<KeptWork> kept = kept_work(input, settings, memory.work, sizes, photos, folder, observer);
  std::optional<ResultKeys> keys;
  SeeOptions see_options{.kept = kept ? &*kept : nullptr};
  if (settings.editable) {
    keys = result_keys(input, settings, photos, observer);
    see_options.on_judged = [&](const labeling::CandidateCollector& collector, const CoverageStore& coverage) {
      write_edit_views(input, *keys, collector, coverage, folder);
    };
  }
  Choice chosen = see_and_choose(input, settings, memory, photos, observer, see_options);
  ModelFiles files(input, settings, folder, observer);
  const atlas::AtlasInput from = atlas_input(input, photos, chosen.graph, chosen.seen, chosen.selection.labels);
  observer.begin({"atlas", "steps"});
  std::optional<atlas::AtlasPlan> plan = plan_and_note(from, settings.atlas, observer);
  files.begin(from.labels, from.tags, plan->estimate());
  atlas::BakeOptions options = bake_options(*plan, settings, memory, photos);
  options.take_model = [&files](const io::TexturedModel& model) {
    return std::async(std::launch::async, [&] { files.write_mesh(model); });
  };
  options.scratch_folder = folder.in_making();
  // Half of what is left beside the result.
  options.coarse_bytes = static_cast<std::size_t>(std::max(0.0, (folder.space() - sizes.likely) / 2));
  if (kept) options.kept = kept->pages();
  std::vector<std::array<int, 2>> page_sizes(plan->estimate().pages);
  options.take_page = [&](std::size_t number, Image page) {
    page_sizes[number] = {page.width, page.height};
    files.write_page(number, std::move(page));
  };
  atlas::TextureAtlas atlas = bake_and_end(*plan, from, settings.atlas, observer, options);
  if (kept) kept->warn_of_failure(observer);
  photos.keep_at_most(0);
  plan.reset();
  chosen.graph = {};
  chosen.seen.candidates.table = {};
  chosen.seen.coverage = {};
  release_freed_memory();
  observer.begin({"write"});
  if (keys)
    write_edit_model({*keys, settings.view_rules, chosen.selection.labels, atlas.model, std::move(page_sizes),
                      atlas.face_chart, atlas.exposure, atlas.statistics.reduction},
                     folder);
  const WrittenModel written = files.finish(atlas.model);
  observer.end("");
  return {finished(std::move(chosen), std::move(atlas)), written};
}

}  // namespace

TexturedMesh texture(const Scene& scene, const Mesh& mesh, const Settings& settings, io::PhotoSource& photos,
                     Observer& observer) {
  const std::vector<ViewId> views = all_views(scene);
  const Input input{scene, mesh, views};
  check_input(input, observer);
  return texture(input, settings, photos, observer);
}

TexturedMesh texture(const Input& input, const Settings& settings, io::PhotoSource& photos, Observer& observer) {
  const MemoryPlan memory = plan_memory(input, settings);
  Choice chosen = see_and_choose(input, settings, memory, photos, observer);
  const atlas::AtlasInput from = atlas_input(input, photos, chosen.graph, chosen.seen, chosen.selection.labels);
  observer.begin({"atlas", "steps"});
  const atlas::AtlasPlan plan = plan_and_note(from, settings.atlas, observer);
  atlas::TextureAtlas atlas =
      bake_and_end(plan, from, settings.atlas, observer, bake_options(plan, settings, memory, photos));
  return finished(std::move(chosen), std::move(atlas));
}

TexturedFiles texture_into(const Input& input, const Settings& settings, io::PhotoSource& photos, OutputFolder& folder,
                           Observer& observer) {
  const MemoryPlan memory = plan_memory(input, settings);
  try {
    return texture_within(memory, input, settings, photos, folder, observer);
  } catch (const std::bad_alloc&) {
    throw MemoryError(fmt::format("out of memory: this run takes about {}, and less was to be had",
                                  results::readable_bytes(memory.peak())),
                      {Cure::limit_memory, Cure::smaller_photos, Cure::fewer_views, Cure::fewer_faces},
                      {{"needed_bytes", memory.peak()}});
  }
}

labeling::FaceGraph weighed_graph(const Mesh& mesh, labeling::EdgeWeights weights, Observer& observer) {
  observer.begin({"face graph"});
  labeling::FaceGraph graph = labeling::face_graph(mesh);
  labeling::weigh_edges(mesh, weights, graph);
  observer.end(results::readable_count(graph.edges.size()) + " edges");
  return graph;
}

labeling::Selection choose(const labeling::CostTable& costs, const labeling::FaceGraph& graph,
                           const labeling::SolverOptions& options, Observer& observer, std::span<const ViewId> fixed) {
  observer.begin({"view selection", "sweeps", true});
  labeling::Selection selection = labeling::select_views(costs, graph, options, observer.reporter(), fixed);
  report_selection(selection, "", observer);
  return selection;
}

atlas::AtlasInput atlas_input(const Input& input, io::PhotoSource& photos, const labeling::FaceGraph& graph,
                              const Seen& seen, std::span<const ViewId> labels) {
  return {input.mesh, input.scene, photos, graph, labels, seen.candidates.tags, seen.candidates.table, seen.coverage};
}

atlas::AtlasPlan plan(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer) {
  observer.begin({"layout"});
  atlas::AtlasPlan made = plan_and_note(input, options, observer);
  observer.end("");
  return made;
}

atlas::TextureAtlas bake(const atlas::AtlasPlan& plan, const atlas::AtlasInput& input,
                         const atlas::AtlasOptions& options, Observer& observer) {
  observer.begin({"atlas", "steps"});
  return bake_and_end(plan, input, options, observer);
}

atlas::TextureAtlas make_atlas(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer) {
  observer.begin({"atlas", "steps"});
  return bake_and_end(plan_and_note(input, options, observer), input, options, observer);
}

}  // namespace gpvc::pipeline
