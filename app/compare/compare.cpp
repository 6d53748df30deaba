#include "app/compare/compare.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <map>
#include <memory>
#include <thread>

#include "app/compare/bias_sweep.h"
#include "app/compare/compare_report.h"
#include "app/compare/compare_views.h"
#include "app/evaluate/evaluate.h"
#include "app/evaluate/oracle_check.h"
#include "app/evaluate/run_log.h"
#include "app/evaluate/scene_json.h"
#include "app/evaluate/texture_islands.h"
#include "app/evaluate/truth_score.h"
#include "io/clock.h"
#include "io/output_file.h"

namespace gpvc::compare {
namespace {

namespace fs = std::filesystem;

/// What every step is given. Borrows all.
struct Run {
  const CompareInput& in;
  const CompareSettings& settings;
  results::OutputFolder& folder;
  results::Observer& observer;

  const Scene& scene() const { return in.input.scene; }
  const Mesh& mesh() const { return in.input.mesh; }
};

/// The truth of a synthetic scene. Its scorer borrows it.
struct KnownTruth {
  evaluate::Truth truth;
  evaluate::TruthScorer scorer;
  KnownTruth(const fs::path& dir, const Run& run)
      : truth(evaluate::read_truth(dir)),
        scorer({truth, run.mesh(), run.scene(), run.in.input.views, run.in.photos}, run.observer.reporter()) {}
  KnownTruth(const KnownTruth&) = delete;
  KnownTruth& operator=(const KnownTruth&) = delete;
};

/// What all models are measured with.
struct Yardsticks {
  std::map<ViewId, visibility::OracleView> oracle;
  ModelViews views;
  std::unique_ptr<KnownTruth> truth;  ///< null where it is not known
};

struct MeasuredModel {
  Json json;                                     ///< of report.json
  std::optional<ShownModel> shown;               ///< empty where the model failed
  std::optional<evaluate::OriginScore> origins;  ///< empty where they are not known
  std::optional<visibility::DeviceInfo> device;
};

/// Passes a mode's stages on, with the mode's name, and keeps its figures.
class ModeLog final : public evaluate::RunLog {
 public:
  ModeLog(results::Observer& whole, std::string mode) : whole_(whole), mode_(std::move(mode)) {}
  void begin(const results::StageInfo& stage) override { whole_.begin(stage); }
  void progress(std::size_t done, std::size_t total) override { whole_.progress(done, total); }
  void end(const std::string& summary) override {
    whole_.stage_figure("mode", mode_);
    whole_.end(summary);
  }
  void note(const std::string& text) override { whole_.note(text); }
  void detail(const std::string& text) override { whole_.detail(text); }
  void warning(const std::string& text, const std::vector<Cure>& cures = {}) override { whole_.warning(text, cures); }
  void stage_figure(const std::string& name, const results::Figure& value) override {
    whole_.stage_figure(name, value);
  }
  void check_cancelled() override { whole_.check_cancelled(); }

 private:
  results::Observer& whole_;
  std::string mode_;
};

// `count` of the views, spread evenly.
std::vector<ViewId> spread(std::span<const ViewId> views, int count) {
  const auto most = static_cast<std::size_t>(count);
  if (views.size() <= most) return {views.begin(), views.end()};
  std::vector<ViewId> some;
  for (std::size_t n = 0; n < most; ++n) some.push_back(views[(2 * n + 1) * views.size() / (2 * most)]);
  return some;
}

std::map<ViewId, visibility::OracleView> find_oracle_views(const Run& run) {
  run.observer.begin({"exact oracle", "views"});
  auto views = evaluate::oracle_views(run.mesh(), run.scene(), run.in.input.views,
                                      static_cast<std::size_t>(run.settings.oracle_views), run.observer.reporter());
  run.observer.end(fmt::format("{} views", views.size()));
  return views;
}

ModelViews prepare_views(const Run& run) {
  const std::span<const ViewId> used = run.in.input.views, held_out = run.in.held_out;
  const int crop_views = run.settings.crops == 0 ? 0 : run.settings.crop_views;
  ModelViewsOptions options;
  options.scored =
      held_out.empty() ? spread(used, run.settings.score_views) : std::vector(held_out.begin(), held_out.end());
  options.cropped = spread(held_out.size() >= static_cast<std::size_t>(crop_views) ? held_out : used, crop_views);
  options.reduction = run.settings.reduction;
  options.renders = run.folder.in_making() / "renders";
  fs::create_directories(options.renders);
  run.observer.begin({"photos to compare with", "views"});
  ModelViews views(run.in.input, run.in.photos, std::move(options), run.observer.reporter());
  run.observer.end(fmt::format("{} views", views.scored().size()));
  return views;
}

// A truth beside the scene that cannot be used is an error only if the settings name it.
std::unique_ptr<KnownTruth> find_truth(const Run& run) {
  fs::path dir = fs::absolute(run.scene().source).lexically_normal();
  if (dir.filename().empty()) dir = dir.parent_path();
  dir = run.settings.truth.value_or(dir.parent_path());
  if (!run.settings.truth && !fs::exists(dir / "surfaces.json")) return nullptr;
  run.observer.begin({"truth", "steps"});
  try {
    auto truth = std::make_unique<KnownTruth>(dir, run);
    run.observer.end("ready");
    return truth;
  } catch (const InputError& error) {
    if (run.settings.truth) throw;
    run.observer.warning(fmt::format("the truth beside the scene is not used: {}", error.what()), error.cures());
    return nullptr;
  }
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.find(':') + 2, line.size()));
  return "unknown processor";
}

std::string scene_name(const fs::path& scene) {
  // A scene is often a folder "colmap" or "sparse/0" within the scene's own folder.
  fs::path path = fs::absolute(scene).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  for (const char* inner : {"0", "sparse", "colmap", "colmap_txt", "undistorted", "dense"})
    if (path.filename() == inner && path.has_parent_path()) path = path.parent_path();
  return path.filename().string();
}

Json names_json(const Scene& scene, std::span<const ViewId> views) {
  Json names = Json::array();
  for (const ViewId view : views) names.push_back(scene.views[index(view)].name);
  return names;
}

// The report before any model is measured.
Json report_header(const Run& run, const Yardsticks& with) {
  const checks::Input& input = run.in.input;
  const Camera& camera = input.scene.views[index(input.views.front())].camera;
  std::vector<ViewId> oracle;
  std::ptrdiff_t tied = 0;
  for (const auto& [id, view] : with.oracle) {
    oracle.push_back(id);
    tied += std::count(view.tied.begin(), view.tied.end(), 1);
  }
  return {
      {"format", "gpvc-compare/1"},
      {"date", fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr)))},
      {"scene",
       {{"name", scene_name(input.scene.source)},
        {"scene", input.scene.source.string()},
        {"mesh", input.mesh_file.string()},
        {"faces", input.mesh.faces.size()},
        {"vertices", input.mesh.positions.size()},
        {"views", input.scene.views.size()},
        {"used_views", input.views.size()},
        {"photo_width", camera.width},
        {"photo_height", camera.height}}},
      {"program",
       {{"version", run.in.version},
        {"processor", processor_name()},
        {"processors", std::thread::hardware_concurrency()},
        {"device", nullptr}}},
      {"settings",
       {{"held_out", names_json(input.scene, run.in.held_out)},
        {"scored", {{"held_out", !run.in.held_out.empty()}, {"views", names_json(input.scene, with.views.scored())}}},
        {"reduction", run.settings.reduction * run.in.downscale},
        {"oracle", {{"views", names_json(input.scene, oracle)}, {"tied_pairs", tied}}},
        {"truth", with.truth ? Json(with.truth->truth.dir.string()) : Json(nullptr)}}},
      {"findings", Json::array()},
      {"modes", Json::array()},
      {"crops", Json::array()}};
}

Json truth_json(const evaluate::TruthScore& score, std::size_t unmatched_faces) {
  return {{"all", evaluate::shares_json(score.all)},
          {"full", evaluate::shares_json(score.full)},
          {"partial", evaluate::shares_json(score.partial)},
          {"samples", score.samples},
          {"unmatched_faces", unmatched_faces}};
}

Json origins_json(const evaluate::OriginScore& score) {
  return {{"all", evaluate::shares_json(score.all)},
          {"full", evaluate::shares_json(score.full)},
          {"partial", evaluate::shares_json(score.partial)},
          {"none", evaluate::shares_json(score.none)},
          {"wrong_points", score.wrong.size()}};
}

/// A model with what its measuring needs. Borrows all.
struct TexturedModel {
  const io::TexturedModel& model;
  const std::vector<Image>& pages;
  WorldPoint offset;                               ///< to be added to the model's positions
  const atlas::TextureOrigins* origins = nullptr;  ///< where its texture comes from; null where that is not known
  std::filesystem::path file{};                    ///< of another program's model
};

// Scores by photos and truth, into `result`.
void score_model(const Run& run, const Yardsticks& with, const TexturedModel& model, std::size_t number, ModeLog& log,
                 MeasuredModel& result) {
  log.begin({"scores", "views"});
  result.shown = with.views.show(number, model.model, model.pages, model.offset, log.reporter());
  result.shown->name = result.json["name"];
  result.json["score"] = evaluate::score_json(result.shown->score);
  if (!model.file.empty() && result.shown->score.windows == 0) {
    result.shown.reset();
    throw InputError(model.file, "", evaluate::kNothingToCompare);
  }
  if (with.truth) {
    const auto matched = evaluate::match_model(run.mesh(), model.model, model.pages, model.offset);
    const auto score = with.truth->scorer.score(matched, [&](std::size_t, std::size_t) { log.check_cancelled(); });
    result.json["truth"] = truth_json(score, matched.unmatched_faces);
    if (model.origins != nullptr) {
      result.origins = with.truth->scorer.score(
          [&](std::uint32_t face, double b, double c) { return std::optional(model.origins->at(FaceId{face}, b, c)); });
      result.json["truth"]["origin"] = origins_json(*result.origins);
    }
  }
  log.end(fmt::format("1-NCC {:.4f}", result.shown->score.ncc_error));
}

Json time_json(const pipeline::Seen& seen, double total_s) {
  const visibility::VisibilityStatistics& t = seen.statistics;
  return {{"visibility_s", t.render_s + t.build_s + t.upload_s + t.readback_s + t.classify_s},
          {"render_s", t.render_s},
          {"build_s", t.build_s},
          {"upload_s", t.upload_s},
          {"readback_s", t.readback_s},
          {"classify_s", t.classify_s},
          {"costs_s", seen.costs_s},
          {"total_s", total_s}};
}

fs::path model_folder(const Run& run, const ComparedMode& mode) {
  std::string name = mode.name;
  std::replace(name.begin(), name.end(), ':', '-');
  return run.folder.in_making() / "modes" / name;
}

void keep_model(const Run& run, const ComparedMode& mode, const pipeline::TexturedMesh& textured, ModeLog& log) {
  results::OutputFolder folder(model_folder(run, mode), true, "texture");
  evaluate::write_views_json(folder.file("views.json"), run.scene(), run.in.input.views, run.in.held_out);
  pipeline::write({run.in.input, run.settings.texture, run.in.photos, log}, textured, folder);
  folder.publish();
}

// The points of a model with another surface's colour.
void write_wrong_points(const Run& run, const fs::path& file, const evaluate::OriginScore& origins) {
  Json points = Json::array();
  for (const evaluate::WrongPoint& p : origins.wrong)
    points.push_back({{"face", p.face},
                      {"photo", run.scene().views[index(p.view)].name},
                      {"x", p.at.x},
                      {"y", p.at.y},
                      {"shows", p.surface}});
  evaluate::write_json(file, points);
}

void measure_mode(const Run& run, const Yardsticks& with, const labeling::FaceGraph& graph, const ComparedMode& mode,
                  std::size_t number, ModeLog& log, MeasuredModel& result) {
  pipeline::Settings settings = run.settings.texture;
  settings.visibility = mode.visibility;
  settings.costs.keep_odd_views = settings.allow_misfit = settings.allow_unseen =
      true;  // all modes are compared on the same views
  const checks::Input& input = run.in.input;
  const auto start = Clock::now();
  evaluate::Confusion confusion;
  const auto compare_classes = [&](ViewId id, const visibility::ViewVisibility& visible) {
    if (const auto found = with.oracle.find(id); found != with.oracle.end())
      confusion.add(visible.classes, found->second);
  };
  pipeline::Seen seen = pipeline::see({input, settings, run.in.photos, log}, {.faces = {}, .on_view = compare_classes});
  result.device = seen.device;
  const std::size_t full = seen.statistics.full, pairs = input.views.size() * run.mesh().faces.size();
  result.json["visible"] = {{"full", full}, {"partial", seen.statistics.partial}, {"occluded", pairs - full}};
  if (!with.oracle.empty()) result.json["oracle"] = confusion.agreement_json();
  for (const char* tag : {"seen", "partial", "filled"})
    result.json["tags"][fmt::format("{}_share", tag)] =
        log.counts["tags"][tag].get<double>() / static_cast<double>(run.mesh().faces.size());
  pipeline::TexturedMesh textured;
  textured.selection = pipeline::choose(seen.candidates.table, graph, settings.solver, log);
  const atlas::AtlasInput atlas_input =
      pipeline::atlas_input(input, run.in.photos, graph, seen, textured.selection.labels);
  textured.tags = seen.candidates.tags;
  textured.atlas = pipeline::make_atlas(atlas_input, settings.atlas, log);
  result.json["time"] = time_json(seen, seconds_since(start));
  result.json["patches"] = textured.selection.patches;
  result.json["counts"] = log.counts;
  if (run.settings.keep_models) keep_model(run, mode, textured, log);
  std::optional<atlas::AtlasPlan> plan;  // the one the atlas was made from, once more: reads no photo
  std::optional<atlas::TextureOrigins> origins;
  if (with.truth) origins.emplace(plan.emplace(atlas::plan_atlas(atlas_input, settings.atlas)), atlas_input);
  score_model(run, with, {textured.atlas.model, textured.atlas.pages, {}, origins ? &*origins : nullptr}, number, log,
              result);
  if (!result.origins) return;
  if (run.settings.keep_models) write_wrong_points(run, model_folder(run, mode) / "wrong.json", *result.origins);
  result.origins->wrong = {};  // may be many, and only areas are compared
}

void measure_external(const Run& run, const Yardsticks& with, const ExternalModel& external, std::size_t number,
                      ModeLog& log, MeasuredModel& result) {
  io::LoadedModel loaded = evaluate::read_model_with_texture(external.file);
  loaded.model.mesh = &loaded.mesh;
  result.json["patches"] = evaluate::texture_islands(loaded.model);
  Scene cameras = run.scene();
  cameras.other_frames.clear();  // it is the model that has to come to where cameras and mesh are
  const checks::Input& input = run.in.input;
  const Remark assumed =
      evaluate::place_model(external.file, input.mesh_file, run.settings.mesh_crs, input.views, cameras, loaded);
  if (!assumed.text.empty()) log.warning(fmt::format("{}: {}", external.name, assumed.text), assumed.cures);
  score_model(run, with, {loaded.model, loaded.pages, loaded.offset, nullptr, external.file}, number, log, result);
}

Json described(const ComparedMode& mode, const BiasScale& scale) {
  Json json{
      {"name", mode.name}, {"kind", "mode"}, {"family", mode.family}, {"epsilon", nullptr}, {"depth_share", nullptr}};
  if (mode.epsilon) {
    json["epsilon"] = *mode.epsilon;
    json["depth_share"] = *mode.epsilon / scale.per_share(mode.family);
  }
  return json;
}

Json described(const ExternalModel& external) {
  return {{"name", external.name}, {"kind", "external"},     {"family", external.name},
          {"epsilon", nullptr},    {"depth_share", nullptr}, {"model", external.file.string()}};
}

// Measures all modes, then the models of other programs.
std::vector<MeasuredModel> measure_all(const Run& run, const Yardsticks& with) {
  const CompareSettings& settings = run.settings;
  const BiasScale scale(run.mesh(), run.scene(), run.in.input.views);
  const labeling::FaceGraph graph = pipeline::weighed_graph(run.mesh(), settings.texture.edge_weights, run.observer);
  const std::size_t all = settings.modes.size() + settings.externals.size();
  const auto start = Clock::now();
  std::vector<MeasuredModel> models;
  const auto add = [&](Json description, const auto& measure) {
    run.observer.check_cancelled();
    const std::string name = description["name"];
    const auto done = static_cast<double>(models.size());
    const double left_s = seconds_since(start) / done * (static_cast<double>(all) - done);
    run.observer.note(fmt::format("{} of {}: {}{}", models.size() + 1, all, name,
                                  models.empty() ? "" : fmt::format(", {} left", results::readable_duration(left_s))));
    MeasuredModel model;
    model.json = std::move(description);
    ModeLog log(run.observer, name);
    try {
      measure(log, model);
      model.json["status"] = "ok";
    } catch (const Cancelled&) {
      throw;
    } catch (const std::exception& error) {
      model.json["status"] = "failed";
      model.json["error"] = error.what();
      const auto* ours = dynamic_cast<const Error*>(&error);
      run.observer.warning(fmt::format("{} failed, the others go on: {}", name, error.what()),
                           ours != nullptr ? ours->cures() : std::vector<Cure>());
    }
    models.push_back(std::move(model));
  };
  for (const ComparedMode& mode : settings.modes)
    add(described(mode, scale),
        [&](ModeLog& log, MeasuredModel& model) { measure_mode(run, with, graph, mode, models.size(), log, model); });
  for (const ExternalModel& external : settings.externals)
    add(described(external),
        [&](ModeLog& log, MeasuredModel& model) { measure_external(run, with, external, models.size(), log, model); });
  return models;
}

// The paired difference of two models' areas, in shares of `whole`, with its standard error, taking each face's points as
// a random sample.
Json area_difference(const std::vector<float>& a, const std::vector<float>& b, double whole) {
  if (whole <= 0) return nullptr;
  double sum = 0, squares = 0;
  for (std::size_t f = 0; f < a.size(); ++f) {
    const double d = static_cast<double>(a[f]) - static_cast<double>(b[f]);
    sum += d;
    squares += d * d;
  }
  return {{"ahead", sum / whole}, {"noise", std::sqrt(squares) / whole}};
}

// How far each model is ahead of gpvc, with standard errors.
void compare_with_gpvc(std::vector<MeasuredModel>& models) {
  const auto gpvc = std::find_if(models.begin(), models.end(),
                                 [](const MeasuredModel& m) { return m.shown && m.shown->name == "gpvc"; });
  if (gpvc == models.end()) return;
  for (MeasuredModel& model : models) {
    if (!model.shown || &model == &*gpvc) continue;
    if (const auto error = difference(*model.shown, *gpvc->shown))
      model.json["against_gpvc"]["error"] = {{"ahead", error->less}, {"noise", error->noise}};
    if (!model.origins || !gpvc->origins || gpvc->origins->all.seen_area <= 0) continue;
    const evaluate::OriginScore &a = *model.origins, &b = *gpvc->origins;
    model.json["against_gpvc"]["right"] = area_difference(a.right_area, b.right_area, b.all.seen_area);
    model.json["against_gpvc"]["faithful"] =
        area_difference(a.faithful_area, b.faithful_area, b.all.seen_area + b.all.hidden_area);
  }
}

// Cuts the crops and writes the report in its three forms.
void write_report(const Run& run, const Yardsticks& with, std::vector<MeasuredModel> models, Json& report) {
  run.observer.begin({"report"});
  compare_with_gpvc(models);
  std::vector<ShownModel> shown;
  for (MeasuredModel& model : models) {
    report["modes"].push_back(std::move(model.json));
    if (model.shown) shown.push_back(std::move(*model.shown));
  }
  const std::vector<Crop> crops = with.views.crops(shown, static_cast<std::size_t>(run.settings.crops));
  for (const Crop& crop : crops) {
    Json errors = Json::object();
    for (std::size_t m = 0; m < shown.size(); ++m) errors[shown[m].name] = crop.errors[m];
    report["crops"].push_back({{"view", crop.view},
                               {"x", crop.x},
                               {"y", crop.y},
                               {"width", crop.width},
                               {"height", crop.height},
                               {"disagreement", crop.disagreement},
                               {"errors", errors}});
  }
  report["findings"] = findings_of(report);
  const std::string page = report_page(report, crops, shown, run.folder.in_making());
  std::error_code ignored;
  fs::remove_all(run.folder.in_making() / "renders", ignored);
  run.folder.promise_all();  // kept models
  io::write_file(run.folder.file("report.html"), page);
  io::write_file(run.folder.file("report.md"), results::printable(report_markdown(report)));
  evaluate::write_json(run.folder.file("report.json"), report);
  run.observer.end(fmt::format("report.html {:.1f} MB", static_cast<double>(page.size()) / 1e6));
}

}  // namespace

CompareSummary compare(const CompareInput& input, const CompareSettings& settings, results::OutputFolder& folder,
                       results::Observer& observer) {
  const Run run{input, settings, folder, observer};
  const Yardsticks yardsticks{find_oracle_views(run), prepare_views(run), find_truth(run)};
  Json report = report_header(run, yardsticks);
  std::vector<MeasuredModel> models = measure_all(run, yardsticks);
  CompareSummary summary{{}, report["settings"], models.size()};
  for (const MeasuredModel& model : models) {
    if (!summary.device) summary.device = model.device;
    if (model.json["status"] != "ok") ++summary.failed;
  }
  report["program"]["device"] = evaluate::device_json(summary.device);
  write_report(run, yardsticks, std::move(models), report);
  return summary;
}

}  // namespace gpvc::compare
