// gpvc compare: reads its input, runs compare::compare() or puts reports together.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "app/cli/scene_input.h"
#include "app/compare/bias_sweep.h"
#include "app/compare/compare.h"

namespace gpvc::cli {
namespace {

using compare::ComparedMode, compare::ExternalModel;

// `sweep` gives the epsilons of modes without one where --eps gives none.
std::vector<ComparedMode> modes_of(const CompareOptions& options, const compare::EpsilonsOf& sweep) {
  const auto given = [&](const std::string&) { return options.epsilons; };
  try {
    return compare::compared_modes(options.modes.empty() ? compare::default_modes() : options.modes,
                                   options.epsilons.empty() ? sweep : given);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("--modes: {}", error.what()));
  }
}

std::vector<ExternalModel> externals_of(const CompareOptions& options, const std::vector<ComparedMode>& modes) {
  std::vector<ExternalModel> externals;
  for (const std::string& given : options.externals) {
    const std::size_t at = given.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == given.size())
      throw UsageError(fmt::format("--external: '{}' is not NAME=MODEL", given));
    ExternalModel one{given.substr(0, at), given.substr(at + 1)};
    const auto same_name = [&](const auto& other) { return other.name == one.name; };
    if (one.name == "photo" || std::any_of(modes.begin(), modes.end(), same_name) ||
        std::any_of(externals.begin(), externals.end(), same_name))
      throw UsageError(fmt::format("--external: the name '{}' is taken", one.name));
    if (!std::filesystem::exists(one.file)) throw InputError(one.file, "", "does not exist");
    externals.push_back(std::move(one));
  }
  return externals;
}

// A quarter of the photo as taken, unless options say otherwise.
int reduction_of(const CompareOptions& options) {
  return options.reduction.value_or(std::max(1, 4 / options.input.downscale));
}

Json options_json(const CompareOptions& options, const compare::CompareSettings& settings) {
  Json json = scene_json(options.input);
  json["modes"] = Json::array();
  for (const ComparedMode& mode : settings.modes) json["modes"].push_back(mode.name);
  json["external"] = options.externals;
  json["truth"] = settings.truth ? Json(settings.truth->string()) : Json(nullptr);
  json["oracle_views"] = settings.oracle_views;
  json["score_views"] = settings.score_views;
  json["reduction"] = settings.reduction;
  json["crops"] = settings.crops;
  json["keep_models"] = settings.keep_models;
  return json;
}

RunFacts compare_scene(const CompareOptions& options, RunRecord& record, results::OutputFolder& folder,
                       compare::CompareSummary& summary) {
  const SceneInputData in = read_scene_input(options.input, record);
  const compare::BiasScale scale(in.mesh, in.scene, in.used);
  compare::CompareSettings settings = options.settings;
  settings.modes = modes_of(options, [&](const std::string& family) { return scale.sweep(family); });
  settings.externals = externals_of(options, settings.modes);
  settings.mesh_crs = options.input.mesh_crs;
  settings.texture.device = options.common.device;
  settings.reduction = reduction_of(options);
  std::set<std::filesystem::path> read = input_files(in);
  for (const ExternalModel& external : settings.externals) read.insert(external.file);
  folder.protect(read);
  // Every mode looks at every photo.
  const std::size_t kept = std::min(pipeline::default_memory_limit() / 4, std::size_t{1} << 30);
  io::PhotoCache photos(in.scene, kept);
  summary = compare::compare({in.input(), in.held_out, photos, options.input.downscale, program_version()}, settings,
                             folder, record);
  record.counts["settings"] = summary.settings;
  record.counts["failed"] = summary.failed;
  return {options_json(options, settings), evaluate::device_json(summary.device)};
}

void summarize(const CompareOptions& options, Console& console) {
  if (!options.input.scene.empty()) throw UsageError("--summarize takes reports; no SCENE and MESH beside it");
  const Json summary = compare::summarize(options.summarize);
  run_command("compare --summarize", options, console, [&](RunRecord&, results::OutputFolder& folder) -> RunFacts {
    compare::write_summary(summary, folder);
    Json given;
    for (const auto& file : options.summarize) given["reports"].push_back(file.string());
    return {given};
  });
  for (const Json& table : summary["tables"]) console.result(table["note"].get<std::string>());
  console.result((options.out / "summary.html").string());
}

}  // namespace

void run_compare(const CompareOptions& options, Console& console) {
  if (!options.summarize.empty()) return summarize(options, console);
  if (options.input.scene.empty() || options.input.mesh.empty())
    throw UsageError("SCENE and MESH are required (or --summarize with reports)");
  // Refuses wrong modes and names before a scene is read for nothing.
  externals_of(options, modes_of(options, [](const std::string&) { return std::vector<double>{1}; }));
  refuse_overwriting(options.input, options.out, {"report.html", "report.md", "report.json"});
  compare::CompareSummary summary;
  run_command("compare", options, console, [&](RunRecord& record, results::OutputFolder& folder) {
    return compare_scene(options, record, folder, summary);
  });
  const std::string report = (options.out / "report.html").string();
  console.result(report);
  if (summary.failed > 0)
    throw std::runtime_error(
        fmt::format("{} of {} models failed; {} says why", summary.failed, summary.models, report));
}

}  // namespace gpvc::cli
