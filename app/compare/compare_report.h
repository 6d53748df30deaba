// The results of a comparison as a page, as Markdown and as JSON.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/compare/compare_views.h"
#include "app/evaluate/json.h"

namespace gpvc::compare {

using evaluate::Json;

/// A figure of a mode: its place in report.json, its name and unit, and whether more or less is better.
struct Figure {
  const char* path;  ///< keys of a mode in report.json, joined by dots
  const char* name;
  const char* unit;  ///< "%": a share, shown times 100
  int digits;
  int better;           ///< 1: more, -1: less, 0: neither
  const char* meaning;  ///< one sentence
};
const std::vector<Figure>& compared_figures();

/// The number under keys joined by dots; nullopt if there is none.
std::optional<double> number_at(const Json& json, const std::string& path);
/// The mode of a report that has this name, or nullptr.
const Json* mode_called(const Json& report, const std::string& name);

/// A figure as tables show it; empty where it is not known.
std::string printed_figure(const std::optional<double>& value, const Figure& figure);

/// What the tables do not say, in sentences.
std::vector<std::string> findings_of(const Json& report);

/// gpvc and each other mode, once at the epsilon that one would pick without the truth and once at the best one, by the
/// main measures: {title, note, columns, rows}; null where no measure is known.
Json opening_table(const Json& report);
/// [{family, by, best, worst}]: of each family with a bias the names of its best and its worst mode by the first measure
/// that is known, which `by` names.
Json best_and_worst(const Json& report);

/// One sentence for each metric of the report: how many modes with a bias are ahead of gpvc, and how many behind.
std::vector<std::string> contest_findings(const Json& report);
/// The same for each mode: {title, note, columns, rows}; null without gpvc or without modes with a bias.
Json contest_table(const Json& report);

/// A table {title, note, columns, rows}, under its title as a heading.
std::string markdown_table(const Json& table);

std::string report_markdown(const Json& report);
/// One self-contained page below 25 MB: report.html with the figures and, as data URIs, the crops of the models shown.
/// `scratch` is an existing folder for a temporary file.
std::string report_page(const Json& report, std::span<const Crop> crops, std::span<const ShownModel> shown,
                        const std::filesystem::path& scratch);

/// report.html of this folder, embedded at build.
extern const char* const kReportTemplate;
/// The page with `data` inserted.
std::string page_with(const Json& data);

}  // namespace gpvc::compare
