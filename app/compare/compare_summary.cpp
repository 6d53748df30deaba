#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>

#include "app/cli/scene_input.h"
#include "app/compare/compare.h"
#include "app/compare/compare_report.h"
#include "app/pipeline/output_folder.h"

namespace gpvc::compare {
namespace {

// A bias is near gpvc within so many percentage points.
constexpr double kNear = 0.1;

struct Measure {
  const char* name;
  std::vector<const char*> path;
};

const std::vector<Measure>& measures() {
  static const std::vector<Measure> all{
      {"classes that agree with the exact oracle", {"oracle", "agreement"}},
      {"area textured faithfully: seen, from pixels of its own surface; hidden, from no other's",
       {"truth", "origin", "all", "faithful"}},
      {"seen area textured from photos' pixels of its own surface", {"truth", "origin", "all", "right"}},
      {"seen area textured, filled or not, in no colour of another surface", {"truth", "all", "right"}}};
  return all;
}

std::optional<double> value_of(const cli::Json& mode, const Measure& measure) {
  const cli::Json* at = &mode;
  for (const char* key : measure.path) {
    if (!at->is_object() || !at->contains(key)) return std::nullopt;
    at = &(*at)[key];
  }
  return at->is_number() ? std::optional(at->get<double>()) : std::nullopt;
}

cli::Json read_report(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file, "", "cannot be read");
  cli::Json report;
  try {
    report = cli::Json::parse(stream);
  } catch (const cli::Json::exception& error) {
    throw InputError(file, "", fmt::format("is not JSON: {}", error.what()));
  }
  const auto has_text = [](const cli::Json& json, const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_string();
  };
  const bool ours = has_text(report, "format") && report["format"] == "gpvc-compare/1" && report.contains("scene") &&
                    has_text(report["scene"], "name") && report.contains("modes") && report["modes"].is_array();
  if (!ours) throw InputError(file, "", "is not a report.json of gpvc compare");
  for (const cli::Json& mode : report["modes"])
    if (!has_text(mode, "name") || !mode.contains("epsilon"))
      throw InputError(file, "", "has a mode without a name or an epsilon; it is not as gpvc compare wrote it");
  return report;
}

const cli::Json* mode_called(const cli::Json& report, const std::string& name) {
  for (const cli::Json& mode : report["modes"])
    if (mode["name"] == name) return &mode;
  return nullptr;
}

/// How far a mode is behind gpvc on each scene, in percentage points; nullopt where it failed or was not run.
struct Row {
  std::string mode;
  std::vector<std::optional<double>> behind;
  std::optional<double> worst() const {
    double most = -1e300;
    for (const auto& value : behind) {
      if (!value) return std::nullopt;
      most = std::max(most, *value);
    }
    return most;
  }
};

struct Table {
  std::vector<const cli::Json*> reports;  ///< those in which gpvc has the measure
  std::vector<Row> rows;
};

Table table_of(const std::vector<cli::Json>& reports, const Measure& measure) {
  Table table;
  std::vector<std::string> names;
  for (const cli::Json& report : reports) {
    const cli::Json* gpvc = mode_called(report, "gpvc");
    if (gpvc == nullptr || !value_of(*gpvc, measure)) continue;
    table.reports.push_back(&report);
    for (const cli::Json& mode : report["modes"]) {
      const std::string name = mode["name"];
      if (mode["epsilon"].is_number() && std::find(names.begin(), names.end(), name) == names.end())
        names.push_back(name);
    }
  }
  for (const std::string& name : names) {
    Row row{name, {}};
    for (const cli::Json* report : table.reports) {
      const cli::Json* mode = mode_called(*report, name);
      const auto value = mode == nullptr ? std::nullopt : value_of(*mode, measure);
      const double best = *value_of(*mode_called(*report, "gpvc"), measure);
      row.behind.push_back(value ? std::optional(100 * (best - *value)) : std::nullopt);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string scene_of(const cli::Json& report) { return report["scene"]["name"]; }

std::string verdict(const Table& table, const Measure& measure) {
  std::string scenes;
  for (const cli::Json* report : table.reports) scenes += (scenes.empty() ? "" : ", ") + scene_of(*report);
  std::vector<std::string> near;
  const Row* best = nullptr;
  for (const Row& row : table.rows) {
    if (!row.worst()) continue;
    if (*row.worst() <= kNear) near.push_back(row.mode);
    if (best == nullptr || *row.worst() < *best->worst()) best = &row;
  }
  const std::string what = fmt::format("By {}", measure.name);
  if (table.rows.empty()) return fmt::format("{} no mode with a bias was compared ({}).", what, scenes);
  if (near.empty())
    return fmt::format(
        "{}, no single epsilon of any method comes within {} percentage points of gpvc on all of {}{}.", what, kNear,
        scenes,
        best ? fmt::format("; the nearest, {}, stays {:.3f} behind on one of them", best->mode, *best->worst()) : "");
  return fmt::format("{}, within {} percentage points of gpvc on all of {}: {}.", what, kNear, scenes,
                     fmt::join(near, ", "));
}

std::string points(const std::optional<double>& value) {
  return value ? fmt::format("{:.3f}", *value) : std::string("not known");
}

cli::Json table_json(const Table& table, const Measure& measure) {
  cli::Json columns = cli::Json::array({"mode"}), rows = cli::Json::array();
  for (const cli::Json* report : table.reports) columns.push_back(scene_of(*report));
  columns.push_back("worst");
  cli::Json gpvc = cli::Json::array({"gpvc itself, %"});
  for (const cli::Json* report : table.reports)
    gpvc.push_back(fmt::format("{:.3f}", 100 * *value_of(*mode_called(*report, "gpvc"), measure)));
  gpvc.push_back("");
  rows.push_back(gpvc);
  for (const Row& row : table.rows) {
    cli::Json cells = cli::Json::array({row.mode});
    for (const auto& value : row.behind) cells.push_back(points(value));
    cells.push_back(points(row.worst()));
    rows.push_back(cells);
  }
  return {{"title", fmt::format("Percentage points behind gpvc: {}", measure.name)},
          {"note", verdict(table, measure)},
          {"columns", columns},
          {"rows", rows}};
}

std::string markdown(const cli::Json& summary) {
  std::string text = "# Biases against gpvc, over all scenes\n";
  for (const cli::Json& table : summary["tables"]) text += markdown_table(table);
  return text;
}

}  // namespace

void summarize_reports(const CompareOptions& options, cli::Console& console) {
  if (!options.texture.input.scene.empty())
    throw cli::UsageError("--summarize takes reports; no SCENE and MESH beside it");
  std::vector<cli::Json> reports;
  for (const auto& file : options.summarize) reports.push_back(read_report(file));
  cli::Json summary{{"format", "gpvc-compare-summary/1"}, {"tables", cli::Json::array()}};
  for (const Measure& measure : measures()) {
    const Table table = table_of(reports, measure);
    if (!table.reports.empty()) summary["tables"].push_back(table_json(table, measure));
  }
  if (summary["tables"].empty())
    throw InputError(options.summarize.front(), "", "and the other reports hold no figure of gpvc to compare with");
  cli::run_command("compare --summarize", options.texture, console,
                   [&](cli::RunRecord&, pipeline::OutputFolder& folder) -> cli::RunFacts {
                     evaluate::write_text(folder.file("summary.html"), page_with(summary));
                     evaluate::write_text(folder.file("summary.md"), markdown(summary));
                     evaluate::write_json(folder.file("summary.json"), summary);
                     cli::Json given = cli::Json::object();
                     for (const auto& file : options.summarize) given["reports"].push_back(file.string());
                     return {given};
                   });
  for (const cli::Json& table : summary["tables"]) console.result(table["note"].get<std::string>());
  console.result((options.texture.out / "summary.html").string());
}

}  // namespace gpvc::compare
