#include "app/pipeline/pipeline.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <future>

#include "app/pipeline/bake_into.h"
#include "app/pipeline/checkpoint.h"
#include "app/pipeline/edit_files.h"
#include "app/pipeline/given_layout.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/stored.h"
#include "app/pipeline/texture_files.h"
#include "io/freed_memory.h"

namespace gpvc::pipeline {

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

namespace {

// Of given labels those that are candidates.
std::vector<ViewId> possible_labels(std::span<const ViewId> given, const labeling::CostTable& table) {
  std::vector<ViewId> labels(given.begin(), given.end());
  for (std::size_t face = 0; face < labels.size(); ++face)
    if (std::ranges::count(table.views_of(face), static_cast<std::uint32_t>(labels[face])) == 0) labels[face] = kNoView;
  return labels;
}

labeling::Selection take_or_choose(const Run& run, const Choice& choice, std::span<const ViewId> given) {
  if (std::optional<labeling::Selection> kept = kept_labels(run)) {
    run.observer.begin({"choose"});
    report_selection(*kept, ", kept by an earlier run", run.observer);
    return std::move(*kept);
  }
  labeling::Selection selection = choose(choice.seen.candidates.table, choice.graph, run.settings.solver, run.observer,
                                         possible_labels(given, choice.seen.candidates.table));
  if (run.kept != nullptr) run.kept->put(kLabelsPart, selection);
  return selection;
}

}  // namespace

Choice see_and_choose(const Run& run, const MemoryPlan& memory, SeeOptions options, const OnJudged& on_judged,
                      std::span<const ViewId> labels) {
  run.photos.keep_at_most(memory.photos_while_seeing());
  Choice choice{weighed_graph(run.input.mesh, run.settings.edge_weights, run.observer), {}, {}};
  options.graph = &choice.graph;
  options.on_looked = [&](double held) { run.photos.keep_at_most(memory.photos_while_judging(held)); };
  const std::size_t decodes = run.photos.decodes().times;
  choice.seen = see(run, options, on_judged);
  run.observer.figure("decodes.see", run.photos.decodes().times - decodes);
  run.photos.keep_at_most(memory.photos_while_choosing());
  release_freed_memory();
  choice.selection = take_or_choose(run, choice, labels);
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
  observer.detail(fmt::format(
      "memory: up to {}; needed at least are {} to see, {} to judge, {} to choose, {} to bake, {} to write",
      results::readable_bytes(memory.limit), results::readable_bytes(need.see), results::readable_bytes(need.judge),
      results::readable_bytes(need.choose), results::readable_bytes(need.bake), results::readable_bytes(need.write)));
}

atlas::AtlasInput with_alignment(atlas::AtlasInput from, std::span<const ShiftField> alignment) {
  from.alignment = alignment;
  return from;
}

TexturedFiles texture_within(const MemoryPlan& memory, const Run& given, OutputFolder& folder,
                             std::span<const LayerPhotos> layers) {
  note_memory(memory, given.observer);
  look_at_layout(given);
  FileSizes sizes = predicted_sizes(given.input, given.settings, memory.work.texels);
  if (given.settings.editable) sizes.likely += edit_bytes(memory.work);
  sizes.likely *= 1 + static_cast<double>(layers.size());
  io::CoarsePhotos with_coarse = with_coarse_photos(given, memory.work, sizes.likely, folder.in_making());
  Run run{given.input, given.settings, with_coarse, given.observer, given.kept};
  const auto& [input, settings, photos, observer, kept] = run;
  folder.expect_space(sizes.least, sizes.likely, observer);
  std::optional<Checkpoint> checkpoint = open_checkpoint(run, memory, sizes, folder);
  if (checkpoint) run.kept = &*checkpoint;
  std::optional<ResultKeys> keys;
  OnJudged on_judged;
  if (settings.editable) {
    keys = result_keys(run);
    on_judged = [&](const labeling::CandidateCollector& collector, const CoverageStore& coverage) {
      write_edit_views(run.input, *keys, collector, coverage, folder);
    };
  }
  Choice chosen = see_and_choose(run, memory, {}, on_judged);
  if (checkpoint) checkpoint->warn_of_failure(observer);
  ModelFiles files(run, folder, chosen.selection.labels, chosen.seen.candidates.tags);
  const atlas::AtlasInput from = atlas_input(input, run.photos, chosen.graph, chosen.seen, chosen.selection.labels);
  const BakeSpace space{.scratch_folder = folder.in_making(),
                        .kept = checkpoint ? checkpoint->pages() : atlas::KeptPages{}};
  atlas::TextureAtlas atlas = bake_into(run, from, with_coverage(memory, chosen.seen.coverage), space, &files);
  if (checkpoint) checkpoint->warn_of_failure(observer);
  run.photos.keep_at_most(0);
  bake_layers(run, layers, with_alignment(from, atlas.alignment), folder);
  chosen.graph = {};
  chosen.seen.candidates.table = {};
  chosen.seen.coverage = {};
  release_freed_memory();
  observer.begin({"write"});
  const WrittenModel written = files.finish(atlas.model, atlas.statistics.cuts);
  if (keys)
    write_edit_model(input,
                     {*keys,
                      settings.view_rules,
                      chosen.selection.labels,
                      atlas.model,
                      files.page_sizes(),
                      atlas.face_chart,
                      atlas.exposure,
                      atlas.alignment,
                      atlas.statistics.reduction,
                      {}},
                     settings.output.texture, folder);
  observer.end("");
  return {finished(std::move(chosen), std::move(atlas)), written};
}

}  // namespace

TexturedMesh texture(Scene& scene, Mesh& mesh, const Settings& settings, io::PhotoSource& photos, Observer& observer) {
  const std::vector<ViewId> views = all_views(scene);
  checks::validate({scene, mesh, views});
  checks::prepare(scene, mesh, views, {}, observer);
  const Input input{scene, mesh, views};
  return texture({input, settings, photos, observer});
}

namespace {

TexturedMesh texture_within(const MemoryPlan& memory, const Run& given) {
  std::error_code failed;
  io::CoarsePhotos with_coarse =
      with_coarse_photos(given, memory.work, 0, std::filesystem::temp_directory_path(failed));
  const Run run{given.input, given.settings, with_coarse, given.observer, given.kept};
  Choice chosen = see_and_choose(run, memory);
  const atlas::AtlasInput from = atlas_input(run.input, run.photos, chosen.graph, chosen.seen, chosen.selection.labels);
  atlas::TextureAtlas atlas = bake_into(run, from, with_coverage(memory, chosen.seen.coverage), {}, nullptr);
  return finished(std::move(chosen), std::move(atlas));
}

}  // namespace

TexturedMesh texture(const Run& run) {
  checks::validate(run.input);
  check_band_format(run.input, run.settings.output);
  look_at_layout(run);
  const MemoryPlan memory = plan_memory(run.input, run.settings);
  return within(memory, [&] { return texture_within(memory, run); });
}

TexturedFiles texture_into(const Run& run, OutputFolder& folder, std::span<const LayerPhotos> layers) {
  checks::validate(run.input);
  check_band_formats(run, layers);
  const MemoryPlan memory = plan_memory(run.input, run.settings);
  return within(memory, [&] { return texture_within(memory, run, folder, layers); });
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
  observer.begin({"choose", "sweeps", true});
  labeling::Selection selection = labeling::select_views(costs, graph, options, observer.reporter(), fixed);
  report_selection(selection, "", observer);
  return selection;
}

atlas::AtlasInput atlas_input(const Input& input, io::PhotoSource& photos, const labeling::FaceGraph& graph,
                              const Seen& seen, std::span<const ViewId> labels) {
  atlas::AtlasInput made{input.mesh,           input.scene,           photos,       graph, labels,
                         seen.candidates.tags, seen.candidates.table, seen.coverage};
  made.layout = input.layout;
  return made;
}

atlas::AtlasPlan plan(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer) {
  observer.begin({"plan"});
  atlas::AtlasPlan made = plan_and_note(input, options, observer);
  observer.end("");
  return made;
}

atlas::TextureAtlas bake(const atlas::AtlasPlan& plan, const atlas::AtlasInput& input,
                         const atlas::AtlasOptions& options, Observer& observer) {
  observer.begin({"bake", "steps"});
  return bake_and_end(plan, input, options, observer);
}

atlas::TextureAtlas make_atlas(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer) {
  observer.begin({"bake", "steps"});
  return bake_and_end(plan_and_note(input, options, observer), input, options, observer);
}

WrittenModel write(const Run& run, const TexturedMesh& textured, OutputFolder& folder) {
  run.observer.begin({"write"});
  const atlas::TextureAtlas& atlas = textured.atlas;
  ModelFiles files(run, folder, textured.selection.labels, textured.tags);
  files.begin({.pages = atlas.pages.size(), .page_texels = atlas.statistics.page_texels});
  std::future<void> mesh = files.take_model(atlas.model);
  tbb::parallel_for(std::size_t{0}, atlas.pages.size(), [&](std::size_t n) {
    run.observer.check_cancelled();
    if (run.input.scene.bands) files.take_samples(n, atlas.samples[n], *run.input.scene.bands);
    files.take_page(n, atlas.pages[n]);
  });
  const WrittenModel written = files.finish(atlas.model, atlas.statistics.cuts);
  mesh.get();
  run.observer.end(fmt::format("{} {}", atlas.pages.size(), atlas.pages.size() == 1 ? "page" : "pages"));
  return written;
}

WrittenModel write(const Scene& scene, const Mesh& mesh, const TexturedMesh& textured, const Settings& settings,
                   const std::filesystem::path& out, Observer& observer) {
  const std::vector<ViewId> views = all_views(scene);
  const Input input{scene, mesh, views};
  io::CallbackSource unused(scene, [](ViewId) { return io::Picture{}; });
  OutputFolder folder(out);
  const WrittenModel written = write({input, settings, unused, observer}, textured, folder);
  folder.publish();
  return written;
}

}  // namespace gpvc::pipeline
