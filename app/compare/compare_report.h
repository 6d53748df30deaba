// The results of a comparison as a page, as Markdown and as JSON.
#pragma once

#include <string>
#include <vector>

#include "app/cli/run_record.h"
#include "app/compare/compare_views.h"

namespace gpvc::compare {

/// report.json as `gpvc compare` fills it; compared_figures() says what the keys of a mode mean.
struct ComparisonReport {
  cli::Json json = cli::Json::object();
  std::vector<Crop> crops;
  std::vector<std::string> shown;  ///< names of the crops' renders, in their order
};

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

/// The value of a mode's figure; null if it has none.
cli::Json figure_of(const cli::Json& mode, const Figure& figure);
std::string printed_figure(const cli::Json& value, const Figure& figure);

/// The main results, in sentences.
std::vector<std::string> findings_of(const cli::Json& report);

/// One sentence for each metric of the report: which modes with a bias are ahead of gpvc.
std::vector<std::string> contest_findings(const cli::Json& report);
/// The same for each mode: {title, note, columns, rows}; null without gpvc or without modes with a bias.
cli::Json contest_table(const cli::Json& report);

/// A table {title, note, columns, rows}, under its title as a heading.
std::string markdown_table(const cli::Json& table);

std::string report_markdown(const cli::Json& report);
/// One self-contained page below 25 MB: report.html with the figures and, as data URIs, the crops. `scratch` is an
/// existing folder for a temporary file.
std::string report_page(const ComparisonReport& report, const std::filesystem::path& scratch);

/// report.html of this folder, embedded at build.
extern const char* const kReportTemplate;
/// The page with `data` inserted.
std::string page_with(const cli::Json& data);

}  // namespace gpvc::compare
