// Several comparisons put together: which biases come near gpvc on each scene.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "app/compare/compare.h"
#include "app/compare/compare_report.h"
#include "io/file_bytes.h"
#include "io/output_file.h"

namespace gpvc::compare {
namespace {

// A bias is near gpvc within so many percentage points.
constexpr double kNear = 0.1;

struct Measure {
  const char *name, *path;
};
constexpr Measure kMeasures[] = {
    {"classes that agree with the exact oracle", "oracle.agreement"},
    {"area textured faithfully: seen, from pixels of its own surface; hidden, from no other's",
     "truth.origin.all.faithful"},
    {"seen area textured from photos' pixels of its own surface", "truth.origin.all.right"},
    {"seen area textured, filled or not, in no colour of another surface", "truth.all.right"}};

Json read_report(const std::filesystem::path& file) {
  const io::FileBytes bytes(file);
  Json report;
  try {
    report = Json::parse(bytes.view());
  } catch (const Json::exception& error) {
    throw InputError(file, "", fmt::format("is not JSON: {}", error.what()));
  }
  const auto has_text = [](const Json& json, const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_string();
  };
  const bool ours = has_text(report, "format") && report["format"] == "gpvc-compare/1" && report.contains("scene") &&
                    has_text(report["scene"], "name") && report.contains("modes") && report["modes"].is_array();
  if (!ours) throw InputError(file, "", "is not the report.json of a comparison");
  for (const Json& mode : report["modes"])
    if (!has_text(mode, "name") || !mode.contains("epsilon"))
      throw InputError(file, "", "has a mode without a name or an epsilon; it is not as the comparison wrote it");
  return report;
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
  std::vector<std::string> scenes;  ///< those in whose reports gpvc has the measure
  std::vector<double> gpvc;         ///< per scene
  std::vector<Row> rows;            ///< modes with a bias
};

Table table_of(const std::vector<Json>& reports, const Measure& measure) {
  Table table;
  std::vector<const Json*> known;
  for (const Json& report : reports) {
    const Json* gpvc = mode_called(report, "gpvc");
    const auto value = gpvc == nullptr ? std::nullopt : number_at(*gpvc, measure.path);
    if (!value) continue;
    known.push_back(&report);
    table.scenes.push_back(report["scene"]["name"].get<std::string>());
    table.gpvc.push_back(*value);
    for (const Json& mode : report["modes"]) {
      const auto same = [&](const Row& row) { return mode["name"] == row.mode; };
      if (mode["epsilon"].is_number() && std::none_of(table.rows.begin(), table.rows.end(), same))
        table.rows.push_back(Row{mode["name"].get<std::string>(), {}});
    }
  }
  for (Row& row : table.rows)
    for (std::size_t n = 0; n < known.size(); ++n) {
      const Json* mode = mode_called(*known[n], row.mode);
      const auto value = mode == nullptr ? std::nullopt : number_at(*mode, measure.path);
      row.behind.push_back(value ? std::optional(100 * (table.gpvc[n] - *value)) : std::nullopt);
    }
  return table;
}

std::string verdict(const Table& table, const Measure& measure) {
  const std::string scenes = fmt::format("{}", fmt::join(table.scenes, ", "));
  std::size_t near = 0;
  const Row* best = nullptr;
  for (const Row& row : table.rows) {
    if (!row.worst()) continue;
    near += *row.worst() <= kNear;
    if (best == nullptr || *row.worst() < *best->worst()) best = &row;
  }
  const std::string what = fmt::format("By {}", measure.name);
  if (table.rows.empty()) return fmt::format("{} no mode with a bias was compared ({}).", what, scenes);
  if (near == 0)
    return fmt::format(
        "{}, no single epsilon of any method comes within {} percentage points of gpvc on all of {}{}.", what, kNear,
        scenes,
        best ? fmt::format("; the nearest, {}, stays {:.3f} behind on one of them", best->mode, *best->worst()) : "");
  return fmt::format("{}, within {} percentage points of gpvc on all of {}: {} of {} modes, the nearest {}.", what,
                     kNear, scenes, near, table.rows.size(), best->mode);
}

std::string points(const std::optional<double>& value) {
  return value ? fmt::format("{:.3f}", *value) : std::string("not known");
}

Json table_json(const Table& table, const Measure& measure) {
  Json columns = Json::array({"mode"}), gpvc = Json::array({"gpvc itself, %"}), rows = Json::array();
  for (const std::string& scene : table.scenes) columns.push_back(scene);
  for (const double value : table.gpvc) gpvc.push_back(fmt::format("{:.3f}", 100 * value));
  columns.push_back("worst");
  gpvc.push_back("");
  rows.push_back(gpvc);
  for (const Row& row : table.rows) {
    Json cells = Json::array({row.mode});
    for (const auto& value : row.behind) cells.push_back(points(value));
    cells.push_back(points(row.worst()));
    rows.push_back(cells);
  }
  return {{"title", fmt::format("Percentage points behind gpvc: {}", measure.name)},
          {"note", verdict(table, measure)},
          {"columns", columns},
          {"rows", rows}};
}

}  // namespace

Json summarize(const std::vector<std::filesystem::path>& files) {
  std::vector<Json> reports;
  for (const auto& file : files) reports.push_back(read_report(file));
  Json summary{{"format", "gpvc-compare-summary/1"}, {"tables", Json::array()}};
  for (const Measure& measure : kMeasures) {
    const Table table = table_of(reports, measure);
    if (!table.scenes.empty()) summary["tables"].push_back(table_json(table, measure));
  }
  if (summary["tables"].empty())
    throw InputError(files.front(), "", "and the other reports hold no figure of gpvc to compare with");
  return summary;
}

void write_summary(const Json& summary, results::OutputFolder& folder) {
  std::string markdown = "# Biases against gpvc, over all scenes\n";
  for (const Json& table : summary["tables"]) markdown += markdown_table(table);
  io::write_file(folder.file("summary.html"), page_with(summary));
  io::write_file(folder.file("summary.md"), markdown);
  evaluate::write_json(folder.file("summary.json"), summary);
}

}  // namespace gpvc::compare
