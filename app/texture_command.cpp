#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <future>

#include "app/interrupt.h"
#include "app/scene_input.h"
#include "app/texture_files.h"

namespace gpvc {
namespace {

// Photos are decoded once where they fit: a quarter of the memory, a gigabyte at most.
std::size_t photo_cache_bytes() {
  const auto memory =
      static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGE_SIZE));
  return std::min(memory / 4, std::size_t{1} << 30);
}

void append_coverage(CoverageTable& all, const CoverageTable& more) {
  for (FaceCoverage entry : more.entries) {
    const std::size_t bits = static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height);
    const auto first = more.words.begin() + static_cast<std::ptrdiff_t>(entry.first_word);
    entry.first_word = all.words.size();
    all.words.insert(all.words.end(), first, first + static_cast<std::ptrdiff_t>((bits + 63) / 64));
    all.entries.push_back(entry);
  }
}

// Only faces that no view sees whole are pieced together from partial ones.
CoverageTable of_partial_faces(const CoverageTable& table, std::span<const FaceTag> tags) {
  CoverageTable kept;
  for (const FaceCoverage& entry : table.entries) {
    if (tags[index(entry.face)] != FaceTag::partial) continue;
    const std::size_t bits = static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height);
    const auto first = table.words.begin() + static_cast<std::ptrdiff_t>(entry.first_word);
    FaceCoverage moved = entry;
    moved.first_word = kept.words.size();
    kept.words.insert(kept.words.end(), first, first + static_cast<std::ptrdiff_t>((bits + 63) / 64));
    kept.entries.push_back(moved);
  }
  return kept;
}

struct SeenScene {
  Candidates candidates;
  CoverageTable coverage;  ///< of faces tagged partial
};

struct ViewTimes {
  double render_s = 0, upload_s = 0, readback_s = 0, classify_s = 0, costs_s = 0;
};

double since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// View after view: while the device draws one, the costs of the one before are taken and the next photo is
// decoded.
SeenScene see_views(const SceneInputData& in, PhotoCache& photos, GraphicsDevice& device,
                    const TextureOptions& options, Console& console, RunRecord& record) {
  Stage stage(console, record, "visibility and costs", "views");
  VisibilityStage visibility(device, in.mesh, options.visibility);
  console.note("classifier: " + visibility.classifier_note());
  record.counts["classifier"] = visibility.classifier_note();
  CandidateCollector collector(in.mesh, options.costs);
  const auto policy = options.common.threads == 1 ? std::launch::deferred : std::launch::async;
  SeenScene seen;
  ViewTimes times;
  std::size_t full = 0, partial = 0;
  std::array<ViewVisibility, 2> buffers;  // one is filled while the costs of the other are taken
  std::future<void> costs;
  for (std::size_t n = 0; n < in.used.size(); ++n) {
    stage.progress(n, in.used.size());
    const ViewId id = in.used[n];
    const View& view = in.scene.views[index(id)];
    auto decoded = std::async(policy, [&photos, id] { return photos.photo(id); });
    ViewVisibility& visible = buffers[n % 2];
    visibility.classify(view, id, visible);
    times.render_s += visible.statistics.render_s;
    times.upload_s += visible.statistics.upload_s;
    times.readback_s += visible.statistics.readback_s;
    times.classify_s += visible.statistics.classify_s;
    if (visible.statistics.full + visible.statistics.partial == 0)
      console.warning(fmt::format(
          "{}: sees no face of the mesh: its camera may lie inside the mesh, or its pose be wrong",
          view.name));
    full += visible.statistics.full;
    partial += visible.statistics.partial;
    append_coverage(seen.coverage, visible.coverage);
    if (costs.valid()) costs.get();
    costs = std::async(policy, [&, id, photo = decoded.share()] {
      const auto pixels = photo.get();
      const auto start = std::chrono::steady_clock::now();
      collector.add_view(id, view, *pixels, visible);
      times.costs_s += since(start);
    });
  }
  costs.get();
  const auto start = std::chrono::steady_clock::now();
  seen.candidates = collector.finish();
  times.costs_s += since(start);
  seen.coverage = of_partial_faces(seen.coverage, seen.candidates.tags);
  for (const auto& [name, value] : {std::pair{"render_s", times.render_s},
                                    {"upload_s", times.upload_s},
                                    {"readback_s", times.readback_s},
                                    {"classify_s", times.classify_s},
                                    {"costs_s", times.costs_s}})
    stage.add(name, value);
  record.counts["full"] = full;
  record.counts["partial"] = partial;
  record.counts["hidden"] = in.used.size() * in.mesh.faces.size() - full - partial;
  stage.finish(fmt::format("{} views", in.used.size()));
  return seen;
}

// What the tags say, and a word where hardly anything is seen: cameras and mesh in two frames.
void count_tags(const Candidates& candidates, const std::filesystem::path& mesh, Console& console,
                RunRecord& record) {
  std::array<std::size_t, 3> counts{};
  for (const FaceTag tag : candidates.tags) ++counts[static_cast<std::size_t>(tag)];
  record.counts["tags"] = {{"seen", counts[0]}, {"partial", counts[1]}, {"filled", counts[2]}};
  record.counts["candidates"] = {
      {"full", candidates.full}, {"partial", candidates.partial}, {"rejected", candidates.rejected}};
  const double total = static_cast<double>(candidates.tags.size());
  console.note(fmt::format("faces: {:.1f} % seen whole by some view, {:.1f} % in parts, {:.1f} % filled",
                           100 * static_cast<double>(counts[0]) / total,
                           100 * static_cast<double>(counts[1]) / total,
                           100 * static_cast<double>(counts[2]) / total));
  if (counts[0] + counts[1] == 0)
    throw InputError(
        mesh, "",
        "no photo sees any face of the mesh: are mesh and cameras in the same coordinates, and the "
        "cameras outside the mesh?");
  if (20 * (counts[0] + counts[1]) < candidates.tags.size())
    console.warning("photos see less than 5 % of the faces; are mesh and cameras in the same coordinates?");
}

Selection choose_views(const SeenScene& seen, const FaceGraph& graph, const TextureOptions& options,
                       Console& console, RunRecord& record) {
  Stage stage(console, record, "view selection", "sweeps", true);
  Selection selection = select_views(seen.candidates.table, graph, options.solver, stage.reporter());
  for (const SweepReport& sweep : selection.sweeps)
    console.detail(
        fmt::format("  sweep {}: energy {:.1f}, {:.2f} s", sweep.sweep, sweep.energy, sweep.seconds));
  record.counts["energy"] = selection.energy;
  record.counts["differing_pairs"] = selection.differing_pairs;
  record.counts["patches"] = selection.patches;
  record.counts["sweeps"] = selection.sweeps.size();
  stage.finish(fmt::format("{} patches, energy {:.0f}", readable_count(selection.patches), selection.energy));
  return selection;
}

TextureAtlas make_atlas(const AtlasInput& input, const TextureOptions& options, Console& console,
                        RunRecord& record) {
  Stage stage(console, record, "atlas", "steps");
  TextureAtlas atlas = build_atlas(input, options.atlas, stage.reporter());
  const AtlasStatistics& s = atlas.statistics;
  stage.add("layout_s", s.layout_s);
  stage.add("leveling_s", s.leveling_s);
  stage.add("baking_s", s.baking_s);
  record.counts["charts"] = s.charts;
  record.counts["filled_faces"] = s.filled_faces;
  record.counts["pages"] = atlas.pages.size();
  record.counts["chart_texels"] = s.chart_texels;
  record.counts["page_texels"] = s.page_texels;
  record.counts["seam_edges"] = s.seam_edges;
  record.counts["seam_step_before"] = s.seam_step_before;
  record.counts["seam_step_after"] = s.seam_step_after;
  const double fill =
      s.page_texels == 0 ? 0 : static_cast<double>(s.chart_texels) / static_cast<double>(s.page_texels);
  stage.finish(fmt::format("{} charts on {} {} ({:.0f} % full), seam step {:.1f} to {:.1f}",
                           readable_count(s.charts), atlas.pages.size(),
                           atlas.pages.size() == 1 ? "page" : "pages", 100 * fill, s.seam_step_before,
                           s.seam_step_after));
  return atlas;
}

Json options_json(const TextureOptions& o) {
  constexpr const char* kTerms[] = {"area", "gmi", "gmi-angle"};
  constexpr const char* kOutliers[] = {"none", "damp", "clamp"};
  constexpr const char* kSeams[] = {"none", "global", "full"};
  Json json = scene_json(o.input);
  json.update(visibility_json(o.visibility));
  json["data_term"] = kTerms[static_cast<std::size_t>(o.costs.term)];
  json["outliers"] = kOutliers[static_cast<std::size_t>(o.costs.outliers)];
  json["margin_px"] = o.costs.margin_px;
  json["smoothness"] = o.solver.smoothness;
  json["edge_weights"] = edge_weights_name(o.edge_weights);
  json["max_sweeps"] = o.solver.max_sweeps;
  json["page_size"] = o.atlas.page_size;
  json["padding"] = o.atlas.padding;
  json["seams"] = kSeams[static_cast<std::size_t>(o.atlas.seams)];
  json["texture"] = o.texture == ImageFormat::png ? "png" : "jpg";
  json["quality"] = o.quality;
  json["gltf"] = o.gltf == GltfContainer::glb ? "glb" : "files";
  json["normals"] = o.normals;
  json["up"] = o.up ? "given" : "auto";
  return json;
}

void texture(const TextureOptions& options, OutputFolder& folder, Console& console) {
  RunRecord record;
  const SceneInputData in = read_scene_input(options.input, console, record);
  GraphicsDevice device(options.common.device);
  console.detail(fmt::format("device: {} ({})", device.info().renderer, device.info().driver));
  PhotoCache photos(in.scene, options.input.reader_options(), photo_cache_bytes());

  Stage adjacency(console, record, "face graph");
  FaceGraph graph = face_graph(in.mesh);
  weigh_edges(in.mesh, options.edge_weights, graph);
  adjacency.finish(readable_count(graph.edges.size()) + " edges");
  const SeenScene seen = see_views(in, photos, device, options, console, record);
  count_tags(seen.candidates, options.input.mesh, console, record);
  const Selection selection = choose_views(seen, graph, options, console, record);
  const TextureAtlas atlas = make_atlas({in.mesh, in.scene, photos, graph, selection.labels,
                                         seen.candidates.tags, seen.candidates.table, seen.coverage},
                                        options, console, record);
  write_textured_scene({in, selection, seen.candidates, atlas}, options, device, folder, console, record);
  write_run_json(folder, {"texture", options.common, options_json(options), device_json(device.info())},
                 record);
}

}  // namespace

void run_texture(const TextureOptions& options, Console& console) {
  refuse_overwriting(options.input, options.out, {"model.obj"});
  OutputFolder folder(options.out, options.force);
  try {
    texture(options, folder, console);
    folder.publish();
  } catch (const OutputError& e) {
    throw std::runtime_error(folder.with_final_names(e.what()));
  }
  for (const char* name : {"model.obj", "model.glb", "model.gltf", "preview.png"})
    if (std::filesystem::exists(options.out / name)) console.result((options.out / name).string());
}

}  // namespace gpvc
