#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <fstream>
#include <thread>

#include "app/cli/scene_input.h"
#include "app/compare/bias_sweep.h"
#include "app/compare/compare.h"
#include "app/compare/compare_modes.h"
#include "app/compare/compare_report.h"
#include "app/compare/compare_truth.h"
#include "app/compare/compare_views.h"
#include "app/evaluate/evaluate.h"
#include "app/evaluate/oracle_check.h"
#include "app/evaluate/texture_islands.h"
#include "app/pipeline/pipeline.h"
#include "io/clock.h"

namespace gpvc::compare {
namespace {

namespace fs = std::filesystem;

struct External {
  std::string name;
  fs::path model;
};

std::vector<ComparedMode> modes_of(const CompareOptions& options, const EpsilonsOf& sweep) {
  return compared_modes(
      options.modes.empty() ? default_modes() : options.modes,
      options.epsilons.empty() ? sweep : [&](const std::string&) { return options.epsilons; },
      options.texture.settings.visibility);
}

std::vector<External> externals_of(const CompareOptions& options, const std::vector<ComparedMode>& modes) {
  std::vector<External> externals;
  for (const std::string& given : options.externals) {
    const std::size_t at = given.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == given.size())
      throw cli::UsageError(fmt::format("--external: '{}' is not NAME=MODEL", given));
    External one{given.substr(0, at), given.substr(at + 1)};
    const auto same_name = [&](const auto& other) { return other.name == one.name; };
    if (one.name == "photo" || std::any_of(modes.begin(), modes.end(), same_name) ||
        std::any_of(externals.begin(), externals.end(), same_name))
      throw cli::UsageError(fmt::format("--external: the name '{}' is taken", one.name));
    if (!fs::exists(one.model)) throw InputError(one.model, "", "does not exist");
    externals.push_back(std::move(one));
  }
  return externals;
}

// `count` of the views, spread evenly.
std::vector<ViewId> spread(const std::vector<ViewId>& views, std::size_t count) {
  if (views.size() <= count) return views;
  std::vector<ViewId> some;
  for (std::size_t n = 0; n < count; ++n) some.push_back(views[(2 * n + 1) * views.size() / (2 * count)]);
  return some;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
  return text.data();
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.find(':') + 2, line.size()));
  return "unknown processor";
}

std::string scene_name(const cli::SceneInput& input) {
  // SCENE is often a folder "colmap" or "sparse/0" within the scene's own folder.
  fs::path path = fs::absolute(input.scene).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  for (const char* inner : {"0", "sparse", "colmap", "colmap_txt", "undistorted", "dense"})
    if (path.filename() == inner && path.has_parent_path()) path = path.parent_path();
  return path.filename().string();
}

cli::Json names_json(const Scene& scene, const std::vector<ViewId>& views) {
  cli::Json names = cli::Json::array();
  for (const ViewId view : views) names.push_back(scene.views[index(view)].name);
  return names;
}

/// One run of `gpvc compare`: what all modes share, and the report as far as it is known.
class Comparison {
 public:
  Comparison(const CompareOptions& options, cli::RunRecord& record, pipeline::OutputFolder& folder)
      : options_(options),
        record_(record),
        folder_(folder),
        in_(cli::read_scene_input(options.texture.input, record_)),
        bias_scale_(in_.mesh, in_.scene, in_.used),
        modes_(modes_of(options, [&](const std::string& family) { return bias_scale_.sweep(family); })),
        externals_(externals_of(options, modes_)),
        photos_(in_.scene, options.texture.input.downscale, pipeline::photo_cache_bytes()),
        graph_(pipeline::weighed_graph(in_.mesh, options.texture.settings.edge_weights, record_)) {}

  cli::RunFacts run() {
    std::set<fs::path> read = cli::input_files(in_);
    for (const External& external : externals_) read.insert(external.model);
    folder_.protect(read);
    prepare();
    const auto start = Clock::now();
    const std::size_t all = modes_.size() + externals_.size();
    for (std::size_t n = 0; n < all; ++n) {
      record_.check_cancelled();
      const std::string& name = n < modes_.size() ? modes_[n].name : externals_[n - modes_.size()].name;
      std::string left;
      if (n > 0)
        left =
            ", " +
            pipeline::readable_duration(seconds_since(start) / static_cast<double>(n) * static_cast<double>(all - n)) +
            " left";
      record_.note(fmt::format("{} of {}: {}{}", n + 1, all, name, left));
      cli::Json mode = n < modes_.size() ? described(modes_[n]) : described(externals_[n - modes_.size()]);
      cli::RunRecord record(record_.console);
      try {
        if (n < modes_.size())
          texture(modes_[n], mode, record);
        else
          load(externals_[n - modes_.size()], mode, record);
        mode["status"] = "ok";
      } catch (const Cancelled&) {
        throw;
      } catch (const std::exception& error) {
        mode["status"] = "failed";
        mode["error"] = error.what();
        record_.warning(fmt::format("{} failed, the others go on: {}", name, error.what()));
        ++failed_;
      }
      for (cli::Json& stage : record.stages) {
        stage["mode"] = name;
        record_.stages.push_back(std::move(stage));
      }
      report_.json["modes"].push_back(std::move(mode));
    }
    write();
    return {given_json(), evaluate::device_json(device_)};
  }

  /// Throws where a model is missing from the report.
  void refuse_failures() const {
    const std::size_t all = modes_.size() + externals_.size();
    if (failed_ > 0)
      throw std::runtime_error(fmt::format("{} of {} models failed; {} says why", failed_, all,
                                           (options_.texture.out / "report.html").string()));
  }

 private:
  // Computes what all modes share: the oracle's classes, the photos to compare with, the truth.
  void prepare() {
    const auto score_views = static_cast<std::size_t>(options_.score_views);
    ModelViewsOptions views;
    views.scored = in_.held_out.empty() ? spread(in_.used, score_views) : in_.held_out;
    const std::size_t crop_views = options_.crops == 0 ? 0 : static_cast<std::size_t>(options_.crop_views);
    views.cropped = spread(in_.held_out.size() >= crop_views ? in_.held_out : in_.used, crop_views);
    views.reduction = options_.scored_reduction();
    views.renders = folder_.in_making() / "renders";
    fs::create_directories(views.renders);
    scored_ = views.scored;

    record_.begin({"exact oracle", "views"});
    oracle_.emplace(in_.mesh, in_.scene, in_.used, static_cast<std::size_t>(options_.oracle_views), record_.reporter());
    record_.end(fmt::format("{} views", oracle_->views()));
    record_.begin({"photos to compare with", "views"});
    views_.emplace(in_.mesh, in_.scene, photos_, views, record_.reporter());
    record_.end(fmt::format("{} views", scored_.size()));
    find_truth();
    report_.json = header();
  }

  // A scene's folder whose truth cannot be used is an error only if --truth names it.
  void find_truth() {
    fs::path dir = options_.truth ? *options_.truth : fs::absolute(options_.texture.input.scene).lexically_normal();
    if (!options_.truth) {
      if (dir.filename().empty()) dir = dir.parent_path();
      dir = dir.parent_path();
      if (!fs::exists(dir / "surfaces.json")) return;
    }
    record_.begin({"truth", "steps"});
    try {
      truth_ = std::make_unique<TruthComparison>(dir, in_.input(), photos_, record_.reporter());
      truth_dir_ = dir;
      record_.end("ready");
    } catch (const InputError& error) {
      if (options_.truth) throw;
      record_.warning(fmt::format("the truth beside the scene is not used: {}", error.what()));
    }
  }

  cli::Json header() const {
    const Camera& camera = in_.scene.views[index(in_.used.front())].camera;
    return {{"format", "gpvc-compare/1"},
            {"date", today()},
            {"scene",
             {{"name", scene_name(options_.texture.input)},
              {"scene", options_.texture.input.scene.string()},
              {"mesh", options_.texture.input.mesh.string()},
              {"faces", in_.mesh.faces.size()},
              {"vertices", in_.mesh.positions.size()},
              {"views", in_.scene.views.size()},
              {"used_views", in_.used.size()},
              {"photo_width", camera.width},
              {"photo_height", camera.height}}},
            {"program",
             {{"version", cli::program_version()},
              {"processor", processor_name()},
              {"processors", std::thread::hardware_concurrency()},
              {"device", nullptr}}},
            {"settings",
             {{"held_out", names_json(in_.scene, in_.held_out)},
              {"scored", {{"held_out", !in_.held_out.empty()}, {"views", names_json(in_.scene, scored_)}}},
              {"reduction", options_.scored_reduction() * options_.texture.input.downscale},
              {"oracle", oracle_->json(in_.scene)},
              {"truth", truth_ ? cli::Json(truth_dir_.string()) : cli::Json(nullptr)}}},
            {"findings", cli::Json::array()},
            {"modes", cli::Json::array()},
            {"crops", cli::Json::array()}};
  }

  cli::Json described(const ComparedMode& mode) const {
    cli::Json json{
        {"name", mode.name}, {"kind", "mode"}, {"family", mode.family}, {"epsilon", nullptr}, {"depth_share", nullptr}};
    if (mode.epsilon) {
      json["epsilon"] = *mode.epsilon;
      json["depth_share"] = *mode.epsilon / bias_scale_.per_share(mode.family);
    }
    return json;
  }
  static cli::Json described(const External& external) {
    return {{"name", external.name}, {"kind", "external"},     {"family", external.name},
            {"epsilon", nullptr},    {"depth_share", nullptr}, {"model", external.model.string()}};
  }

  void texture(const ComparedMode& mode, cli::Json& json, cli::RunRecord& record) {
    pipeline::Settings settings = options_.texture.settings;
    settings.visibility = mode.visibility;
    settings.device = options_.texture.common.device;
    const pipeline::Input input = in_.input();
    const auto start = Clock::now();
    evaluate::Confusion confusion;
    const auto compare = [&](ViewId id, const visibility::ViewVisibility& visible) {
      oracle_->compare(id, visible.classes, confusion);
    };
    pipeline::Seen seen = pipeline::see(input, settings, photos_, record, {.faces = {}, .on_view = compare});
    if (!device_) {
      device_ = seen.device;
      report_.json["program"]["device"] = evaluate::device_json(device_);
    }
    const visibility::VisibilityStatistics& t = seen.statistics;
    const std::size_t pairs = in_.used.size() * in_.mesh.faces.size();
    json["visible"] = {{"full", t.full}, {"partial", t.partial}, {"occluded", pairs - t.full}};
    if (oracle_->views() > 0) json["oracle"] = confusion.agreement_json();
    json["time"] = {{"visibility_s", t.render_s + t.build_s + t.upload_s + t.readback_s + t.classify_s},
                    {"render_s", t.render_s},
                    {"build_s", t.build_s},
                    {"upload_s", t.upload_s},
                    {"readback_s", t.readback_s},
                    {"classify_s", t.classify_s},
                    {"costs_s", seen.costs_s}};
    const auto tag_share = [&](const char* tag) {
      return record.counts["tags"][tag].get<double>() / static_cast<double>(in_.mesh.faces.size());
    };
    json["tags"] = {{"seen_share", tag_share("seen")},
                    {"partial_share", tag_share("partial")},
                    {"filled_share", tag_share("filled")}};
    pipeline::TexturedMesh textured;
    textured.selection = pipeline::choose(seen.candidates.table, graph_, settings.solver, record);
    const atlas::AtlasInput atlas_input =
        pipeline::atlas_input(input, photos_, graph_, seen, textured.selection.labels);
    textured.tags = seen.candidates.tags;
    textured.atlas = pipeline::make_atlas(atlas_input, settings.atlas, record);
    json["time"]["total_s"] = seconds_since(start);
    json["patches"] = textured.selection.patches;
    json["counts"] = record.counts;
    if (options_.keep_models) keep(mode, textured, settings, record);
    std::optional<atlas::AtlasPlan> plan;  // the one the atlas was made from, once more: reads no photo
    std::optional<atlas::TextureOrigins> origins;
    if (truth_) origins.emplace(plan.emplace(atlas::plan_atlas(atlas_input, settings.atlas)), atlas_input);
    measure(mode.name, textured.atlas.model, textured.atlas.pages, {}, origins ? &*origins : nullptr, json, record);
    if (truth_ && options_.keep_models) evaluate::write_json(mode_folder(mode) / "wrong.json", truth_->wrong_points());
  }

  void load(const External& external, cli::Json& json, cli::RunRecord& record) {
    io::LoadedModel loaded = evaluate::read_model_with_texture(external.model);
    loaded.model.mesh = &loaded.mesh;
    json["patches"] = evaluate::texture_islands(loaded.model);
    measure(external.name, loaded.model, loaded.pages, loaded.offset, nullptr, json, record);
  }

  void measure(const std::string& name, const io::TexturedModel& model, const std::vector<Image>& pages,
               const WorldPoint& offset, const atlas::TextureOrigins* origins, cli::Json& json,
               cli::RunRecord& record) {
    record.begin({"scores", "views"});
    json["score"] = evaluate::score_json(views_->show(model, pages, offset, record.reporter()));
    report_.shown.push_back(name);
    if (truth_)
      json["truth"] =
          truth_->score(model, pages, offset, origins, [&](std::size_t, std::size_t) { record.check_cancelled(); });
    record.end(fmt::format("1-NCC {:.4f}", json["score"]["one_minus_ncc"].get<double>()));
  }

  fs::path mode_folder(const ComparedMode& mode) const {
    std::string name = mode.name;
    std::replace(name.begin(), name.end(), ':', '-');
    return folder_.in_making() / "modes" / name;
  }

  void keep(const ComparedMode& mode, const pipeline::TexturedMesh& textured, const pipeline::Settings& settings,
            cli::RunRecord& record) {
    pipeline::OutputFolder folder(mode_folder(mode), true, "texture");
    evaluate::write_views_json(folder.file("views.json"), in_.scene, in_.used, in_.held_out);
    pipeline::write(in_.input(), textured, settings, folder, record);
    folder.publish();
  }

  // The difference of each mode to gpvc, with its standard error.
  void compare_with_gpvc() {
    const auto at = [&](const std::string& name) {
      return static_cast<std::size_t>(std::find(report_.shown.begin(), report_.shown.end(), name) -
                                      report_.shown.begin());
    };
    const std::size_t gpvc = at("gpvc");
    if (gpvc == report_.shown.size()) return;
    for (cli::Json& mode : report_.json["modes"]) {
      const std::size_t n = at(mode["name"]);
      if (n == report_.shown.size() || n == gpvc) continue;
      const ErrorDifference error = views_->difference(n, gpvc);
      if (error.known) mode["against_gpvc"]["error"] = {{"ahead", error.less}, {"noise", error.noise}};
      const cli::Json areas = truth_ ? truth_->ahead(n, gpvc) : cli::Json(nullptr);
      if (!areas.is_null()) mode["against_gpvc"].update(areas);
    }
  }

  void write() {
    record_.begin({"report"});
    compare_with_gpvc();
    cli::Json& json = report_.json;
    report_.crops = views_->crops(static_cast<std::size_t>(options_.crops));
    for (const Crop& crop : report_.crops) {
      cli::Json errors = cli::Json::object();
      for (std::size_t m = 0; m < report_.shown.size(); ++m) errors[report_.shown[m]] = crop.errors[m];
      json["crops"].push_back({{"view", crop.view},
                               {"x", crop.x},
                               {"y", crop.y},
                               {"width", crop.width},
                               {"height", crop.height},
                               {"disagreement", crop.disagreement},
                               {"errors", errors}});
    }
    json["findings"] = findings_of(json);
    const std::string page = report_page(report_, folder_.in_making());
    std::error_code ignored;
    fs::remove_all(folder_.in_making() / "renders", ignored);
    folder_.promise_all();  // kept models
    evaluate::write_text(folder_.file("report.html"), page);
    evaluate::write_text(folder_.file("report.md"), report_markdown(json));
    evaluate::write_json(folder_.file("report.json"), json);
    record_.end(fmt::format("report.html {:.1f} MB", static_cast<double>(page.size()) / 1e6));
    record_.counts["settings"] = json["settings"];
    record_.counts["failed"] = failed_;
  }

  cli::Json given_json() const {
    cli::Json given = cli::scene_json(options_.texture.input);
    given["modes"] = cli::Json::array();
    for (const ComparedMode& mode : modes_) given["modes"].push_back(mode.name);
    given["external"] = options_.externals;
    given["truth"] = options_.truth ? cli::Json(options_.truth->string()) : cli::Json(nullptr);
    given["oracle_views"] = options_.oracle_views;
    given["score_views"] = options_.score_views;
    given["reduction"] = options_.scored_reduction();
    given["crops"] = options_.crops;
    given["keep_models"] = options_.keep_models;
    return given;
  }

  const CompareOptions& options_;
  cli::RunRecord& record_;
  pipeline::OutputFolder& folder_;
  cli::SceneInputData in_;
  BiasScale bias_scale_;
  std::vector<ComparedMode> modes_;
  std::vector<External> externals_;
  std::vector<ViewId> scored_;
  std::optional<visibility::DeviceInfo> device_;  ///< of the first mode that used one
  io::PhotoCache photos_;
  labeling::FaceGraph graph_;
  std::optional<evaluate::OracleViews> oracle_;
  std::optional<ModelViews> views_;
  std::unique_ptr<TruthComparison> truth_;
  fs::path truth_dir_;
  std::size_t failed_ = 0;
  ComparisonReport report_;
};

}  // namespace

void run_compare(const CompareOptions& options, cli::Console& console) {
  if (!options.summarize.empty()) return summarize_reports(options, console);
  const cli::SceneInput& input = options.texture.input;
  if (input.scene.empty() || input.mesh.empty())
    throw cli::UsageError("SCENE and MESH are required (or --summarize with reports)");
  // Refuses wrong modes and names before a scene is read for nothing.
  externals_of(options, modes_of(options, [](const std::string&) { return std::vector<double>{1}; }));
  cli::refuse_overwriting(input, options.texture.out, {"report.html", "report.md", "report.json"});
  std::optional<Comparison> comparison;
  const auto compare = [&](cli::RunRecord& record, pipeline::OutputFolder& folder) {
    return comparison.emplace(options, record, folder).run();
  };
  cli::run_command("compare", options.texture, console, compare);
  console.result((options.texture.out / "report.html").string());
  comparison->refuse_failures();
}

}  // namespace gpvc::compare
