// What a comparison found, as a page, as Markdown and as JSON.
#pragma once

#include <string>
#include <vector>

#include "app/cli/run_record.h"
#include "app/compare/compare_views.h"

namespace gpvc::compare {

/// report.json as `gpvc compare` fills it; the keys of a mode are documented by figures_explained().
struct ComparisonReport {
  cli::Json json = cli::Json::object();
  std::vector<Crop> crops;
  std::vector<std::string> shown;  ///< names of the crops' renders, in their order
};

/// A figure of a mode: where it lies in report.json, how it is called and counted, which end is better.
struct Figure {
  const char* path;  ///< keys of a mode in report.json, joined by dots
  const char* name;
  const char* unit;  ///< "%": a share, shown times 100
  int digits;
  int better;           ///< 1: more, -1: less, 0: neither
  const char* meaning;  ///< one sentence
};
const std::vector<Figure>& compared_figures();

/// The figure of a mode; null where there is none.
cli::Json figure_of(const cli::Json& mode, const Figure& figure);
std::string printed_figure(const cli::Json& value, const Figure& figure);

/// What the figures say, in sentences.
std::vector<std::string> findings_of(const cli::Json& report);

/// Whether a mode with a bias is ahead of gpvc, by each measure the report has: a sentence each.
std::vector<std::string> contest_findings(const cli::Json& report);
/// The same mode by mode: {title, note, columns, rows}; null without gpvc or a bias.
cli::Json contest_table(const cli::Json& report);

/// A {title, note, columns, rows} under a heading.
std::string markdown_table(const cli::Json& table);

std::string report_markdown(const cli::Json& report);
/// One self-contained page: the template of report.html with the figures and the crops as data URIs, below 25 MB.
/// `scratch` is an existing folder for a file in between.
std::string report_page(const ComparisonReport& report, const std::filesystem::path& scratch);

/// report.html of this folder, embedded at build.
extern const char* const kReportTemplate;
/// The template with `data` in it.
std::string page_with(const cli::Json& data);

}  // namespace gpvc::compare
