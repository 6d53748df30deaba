// gpvc evaluate: a textured model against the photos, or against the truth of a synthetic scene.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <optional>

#include "app/checks/mesh_frame.h"
#include "app/checks/nearness.h"
#include "app/cli/interrupt.h"
#include "app/cli/scene_input.h"
#include "app/evaluate/evaluate.h"
#include "app/evaluate/truth_score.h"
#include "app/results/output_folder.h"
#include "io/mesh.h"
#include "io/npy.h"

namespace gpvc::cli {
namespace {

// The views of these names; all views where none has one of them.
std::vector<ViewId> named_views(std::span<const View> views, const std::vector<std::string>& names) {
  std::vector<ViewId> some, all;
  for (std::uint32_t v = 0; v < views.size(); ++v) {
    all.push_back(ViewId{v});
    if (std::find(names.begin(), names.end(), views[v].name) != names.end()) some.push_back(ViewId{v});
  }
  return some.empty() ? all : some;
}

Scene with_views(const Scene& scene, const std::vector<ViewId>& views) {
  Scene chosen = scene;
  chosen.views.clear();
  for (const ViewId id : views) chosen.views.push_back(scene.views[index(id)]);
  return chosen;
}

// The photo that each face shows, from the files that gpvc writes beside a model. None for models of other programs, and
// where the files belong to another scene.
std::optional<evaluate::OriginOf> known_origins(const std::filesystem::path& model, const Mesh& mesh,
                                                const Scene& scene) {
  const std::filesystem::path folder = model.parent_path();
  for (const char* name : {"views.json", "labels.npy", "tags.npy"})
    if (!std::filesystem::exists(folder / name)) return std::nullopt;
  std::vector<std::int32_t> labels = io::read_npy<std::int32_t>(folder / "labels.npy").values;
  std::vector<std::uint8_t> tags = io::read_npy<std::uint8_t>(folder / "tags.npy").values;
  if (labels.size() != mesh.faces.size() || tags.size() != mesh.faces.size()) return std::nullopt;
  std::map<std::string, std::int32_t> number;  // views by name: another format may list them in another order
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    number.emplace(scene.views[v].name, static_cast<std::int32_t>(v));
  std::vector<std::int32_t> now;
  for (const std::string& name : listed_views(model)) {
    const auto found = number.find(name);
    now.push_back(found == number.end() ? -1 : found->second);
  }
  for (std::int32_t& label : labels) {
    if (label < 0) continue;
    if (static_cast<std::size_t>(label) >= now.size() || now[static_cast<std::size_t>(label)] < 0) return std::nullopt;
    label = now[static_cast<std::size_t>(label)];
  }
  return evaluate::origins_of_labels(mesh, scene, std::move(labels), std::move(tags));
}

// The views whose photos the model's renders are compared with.
std::vector<ViewId> compared_views(const EvaluateCommandOptions& options, std::span<const View> views) {
  const std::vector<ViewId> left = used_views(views, options.input.views, options.input.exclude_views);
  if (!options.input.views.empty()) return left;
  std::vector<ViewId> compared = named_views(views, marked_views(options.model, "held_out"));
  std::erase_if(compared, [&](ViewId id) { return !std::ranges::binary_search(left, id); });
  if (compared.empty())
    throw UsageError("--exclude-views leaves no view to compare with: all held-out views are among its");
  return compared;
}

// The views whose photos are read, for the comparison and for the score against the truth.
std::vector<bool> needed_views(const EvaluateCommandOptions& options, std::span<const View> views) {
  std::vector<ViewId> needed = compared_views(options, views);
  if (!options.truth.empty()) {
    const std::vector<ViewId> used = named_views(views, marked_views(options.model, "used"));
    needed.insert(needed.end(), used.begin(), used.end());
  }
  return marked(needed, views.size());
}

// What is evaluated, in the coordinates of the cameras.
class Evaluated {
 public:
  // Reads all, and brings it into the same coordinates.
  Evaluated(const EvaluateCommandOptions& options, RunRecord& record);
  Evaluated(const Evaluated&) = delete;
  Evaluated& operator=(const Evaluated&) = delete;

  Scene scene;
  io::LoadedModel model;
  std::optional<Mesh> mesh;                       // of --mesh, or of the truth's folder
  std::optional<evaluate::MatchedModel> matched;  // with --truth: the model's faces as those of the mesh
};

Evaluated::Evaluated(const EvaluateCommandOptions& options, RunRecord& record) {
  io::SceneOptions reader = options.input.reader_options();
  reader.needed = [&](std::span<const View> views) { return needed_views(options, views); };
  record.begin({"read"});
  results::OutputFolder::finish_interrupted(std::filesystem::absolute(options.model).parent_path());
  check_places(options.input, "MODEL comes first, then SCENE");
  scene = io::read_scene(options.input.scene, reader);
  if (options.input.skip_bad_photos) std::erase_if(scene.views, [](const View& view) { return view.photo.empty(); });
  for (const std::string& warning : scene.warnings) record.warning(warning);
  model = evaluate::read_model_with_texture(options.model);
  model.model.mesh = &model.mesh;
  std::filesystem::path mesh_file = options.input.mesh;
  if (mesh_file.empty() && !options.truth.empty()) mesh_file = options.truth / "mesh.ply";
  if (!mesh_file.empty()) mesh = io::read_mesh(mesh_file);
  for (const std::string& warning : model.mesh.warnings)
    record.warning(fmt::format("{}: {}", options.model.string(), warning));
  if (!options.truth.empty()) matched = evaluate::match_model(*mesh, model.model, model.pages, model.offset);

  const std::vector<bool> needed = needed_views(options, scene.views);
  std::vector<ViewId> used;
  for (std::uint32_t v = 0; v < needed.size(); ++v)
    if (needed[v]) used.push_back(ViewId{v});
  const std::string& crs = options.input.mesh_crs;
  Remark of_mesh;
  if (mesh) of_mesh = checks::match_frames(scene, *mesh, used, mesh_file, crs);
  if (!of_mesh.text.empty()) record.warning(of_mesh.text, of_mesh.cures);
  if (mesh) scene.other_frames.clear();  // cameras stay where the mesh is
  const Remark of_model = evaluate::place_model(options.model, mesh_file, crs, used, scene, model);
  if (!of_model.text.empty() && of_model.text != of_mesh.text)
    record.warning(fmt::format("{}: {}", options.model.string(), of_model.text), of_model.cures);
  // What the photos are compared with must not depend on a model where there is the mesh.
  if (mesh)
    checks::set_nearness(scene, *mesh);
  else
    checks::set_nearness(scene, model.mesh, model.offset);
  record.end(fmt::format("{} faces, {} views", results::readable_count(model.mesh.faces.size()), used.size()));
}

Json truth_json(const evaluate::TruthScore& score) {
  return {{"light", evaluate::light_json(score.light)},
          {"all", evaluate::shares_json(score.all)},
          {"seen_whole", evaluate::shares_json(score.full)},
          {"seen_in_parts", evaluate::shares_json(score.partial)},
          {"faces", score.faces},
          {"textured_faces", score.textured},
          {"samples", score.samples}};
}

void score_truth(const EvaluateCommandOptions& options, const Evaluated& in, RunRecord& record) {
  record.begin({"truth", "steps"});
  const evaluate::Truth truth = evaluate::read_truth(options.truth);
  const evaluate::MatchedModel& matched = *in.matched;
  if (matched.unmatched_faces == in.model.mesh.faces.size())
    throw InputError(options.model, "",
                     "none of its faces is a face of the scene's mesh: was it made from another mesh?");
  if (matched.unmatched_faces > 0)
    record.warning(fmt::format("{} of the model's {} faces are none of the mesh's and are left out",
                               matched.unmatched_faces, in.model.mesh.faces.size()));
  const std::vector<ViewId> used = named_views(in.scene.views, marked_views(options.model, "used"));
  io::PhotoCache photos(in.scene, 0);
  const Progress progress = record.reporter();
  const std::size_t views = used.size(), steps = 4 * views;  // the scorer goes through the views three times
  const evaluate::TruthScorer scorer({truth, *in.mesh, in.scene, used, photos}, results::part_of(progress, 0, steps));
  const evaluate::TruthScore score = scorer.score(matched, results::part_of(progress, 3 * views, steps));
  record.counts["truth"] = truth_json(score);
  std::optional<evaluate::OriginScore> origins;
  if (const std::optional<evaluate::OriginOf> origin = known_origins(options.model, *in.mesh, in.scene)) {
    origins = scorer.score(*origin);
    record.counts["truth"]["origin"] = {{"all", evaluate::shares_json(origins->all)},
                                        {"seen_whole", evaluate::shares_json(origins->full)},
                                        {"seen_in_parts", evaluate::shares_json(origins->partial)},
                                        {"seen_by_none", evaluate::shares_json(origins->none)}};
  }
  record.end(fmt::format("{} points in {} views", score.samples, used.size()));
  record.console.result(evaluate::truth_table(score, origins ? &*origins : nullptr));
}

// Compares renders of the model with the photos and prints the table; pictures and JSON go to the folder.
void compare_photos(const EvaluateCommandOptions& options, const Evaluated& in, RunRecord& record,
                    const results::OutputFolder* folder) {
  record.begin({"evaluate", "views"});
  const std::vector<ViewId> views = compared_views(options, in.scene.views);
  const std::vector<std::string> held_out = marked_views(options.model, "held_out");
  const bool known = std::ranges::any_of(
      in.scene.views, [&](const View& view) { return std::ranges::find(held_out, view.name) != held_out.end(); });
  if (options.input.views.empty() && known)
    record.note(
        fmt::format("comparing with the {} views that views.json beside the model marks as held out", views.size()));
  if (options.input.views.empty() && !known && !held_out.empty())
    record.warning(
        "none of the views that views.json beside the model marks as held out is one of the scene: all are compared, "
        "those that the model was textured from too; --views names others");
  const Scene chosen = with_views(in.scene, views);
  io::PhotoCache photos(chosen, 0);
  evaluate::EvaluateOptions evaluate;
  evaluate.model = options.model;
  if (!options.input.mesh.empty()) evaluate.mesh = &*in.mesh;
  if (folder) evaluate.out = folder->in_making();
  evaluate.reduction = options.reduction;
  const evaluate::Evaluation evaluation =
      evaluate::evaluate_model(chosen, photos, in.model, evaluate, record.reporter());
  record.end(fmt::format("{} views", chosen.views.size()));
  record.console.result(evaluate::evaluation_table(evaluation));
}

Json options_json(const EvaluateCommandOptions& options) {
  Json json = scene_json(options.input);
  json["model"] = options.model.string();
  json["truth"] = options.truth.string();
  json["reduction"] = options.reduction;
  return json;
}

// `folder`: null for none.
RunFacts evaluate_into(const EvaluateCommandOptions& options, RunRecord& record, results::OutputFolder* folder) {
  const Evaluated in(options, record);
  if (folder != nullptr) {
    std::set<std::filesystem::path> read = input_files(in.scene);
    read.insert({options.model, options.input.mesh, options.truth / "truth.json"});
    folder->protect(read);
  }
  if (!options.truth.empty()) score_truth(options, in, record);
  if (options.truth.empty() || folder != nullptr || !options.input.views.empty())
    compare_photos(options, in, record, folder);
  if (folder != nullptr) folder->promise_all();
  return {options_json(options)};
}

}  // namespace

void run_evaluate(const EvaluateCommandOptions& options, Console& console) {
  if (options.out.empty()) {
    const EndsSoonAfterSignal ends([&] { console.interrupted(); });
    RunRecord record(console);
    evaluate_into(options, record, nullptr);
    return;
  }
  run_command("evaluate", options, console, [&](RunRecord& record, results::OutputFolder& folder) {
    return evaluate_into(options, record, &folder);
  });
}

}  // namespace gpvc::cli
