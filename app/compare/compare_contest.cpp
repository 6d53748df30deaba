// Modes with a bias beside gpvc, metric by metric: which is better, and which differences may be chance.
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "app/compare/compare_report.h"

namespace gpvc::compare {
namespace {

// Differences of fewer standard errors are called ties: chance alone exceeds them once in twenty.
constexpr double kSure = 2;

enum class Standing { behind, tie, ahead };

struct Result {
  double ahead = 0;
  std::optional<double> noise;  ///< one standard error; nullopt if every pair was counted
  Standing standing() const {
    if (std::abs(ahead) <= kSure * noise.value_or(0)) return Standing::tie;
    return ahead > 0 ? Standing::ahead : Standing::behind;
  }
};

struct Metric {
  const char* name;
  const char* heading;
  double factor;  ///< of the printed numbers
  int digits;
  std::optional<Result> (*of)(const cli::Json& mode, const cli::Json& gpvc);
};

std::optional<Result> against(const cli::Json& mode, const char* key) {
  if (!mode.contains("against_gpvc") || !mode["against_gpvc"].contains(key)) return std::nullopt;
  const cli::Json& result = mode["against_gpvc"][key];
  return Result{result["ahead"].get<double>(), result["noise"].get<double>()};
}

const Metric kMetrics[] = {
    {"seen area textured rightly", "Textured rightly, points", 100, 4,
     [](const cli::Json& mode, const cli::Json&) { return against(mode, "right"); }},
    {"area textured faithfully", "Textured faithfully, points", 100, 4,
     [](const cli::Json& mode, const cli::Json&) { return against(mode, "faithful"); }},
    {"classes that agree with the oracle", "Oracle, points", 100, 4,
     [](const cli::Json& mode, const cli::Json& gpvc) -> std::optional<Result> {
       if (!mode.contains("oracle") || !gpvc.contains("oracle")) return std::nullopt;
       return Result{mode["oracle"]["agreement"].get<double>() - gpvc["oracle"]["agreement"].get<double>(),
                     std::nullopt};
     }},
    {"error of renders", "1 - NCC, less by", 1, 4,
     [](const cli::Json& mode, const cli::Json&) { return against(mode, "error"); }},
};

std::string printed(const Result& result, const Metric& metric) {
  const char* words[] = {"behind", "tie", "ahead"};
  std::string text = fmt::format("{:+.{}f}", metric.factor * result.ahead, metric.digits);
  if (result.noise) text += fmt::format(" ± {:.{}f}", metric.factor * *result.noise, metric.digits);
  return text + ", " + words[static_cast<std::size_t>(result.standing())];
}

const cli::Json* gpvc_of(const cli::Json& report) {
  for (const cli::Json& mode : report["modes"])
    if (mode["name"] == "gpvc" && mode["status"] == "ok") return &mode;
  return nullptr;
}

}  // namespace

std::vector<std::string> contest_findings(const cli::Json& report) {
  std::vector<std::string> findings;
  const cli::Json* gpvc = gpvc_of(report);
  if (gpvc == nullptr) return findings;
  for (const Metric& metric : kMetrics) {
    std::vector<std::string> ahead, ties;
    std::size_t behind = 0;
    for (const cli::Json& mode : report["modes"]) {
      if (!mode["epsilon"].is_number() || mode["status"] != "ok") continue;
      const std::optional<Result> result = metric.of(mode, *gpvc);
      if (!result) continue;
      const std::string name = mode["name"];
      if (result->standing() == Standing::behind) ++behind;
      if (result->standing() == Standing::tie) ties.push_back(name);
      if (result->standing() == Standing::ahead)
        ahead.push_back(fmt::format("{} ({})", name, printed(*result, metric)));
    }
    const std::size_t all = ahead.size() + ties.size() + behind;
    if (all == 0) continue;
    std::string text = ahead.empty()
                           ? fmt::format("By {} no mode with a bias is ahead of gpvc at any epsilon", metric.name)
                           : fmt::format("By {} ahead of gpvc: {}", metric.name, fmt::join(ahead, ", "));
    if (!ties.empty()) text += fmt::format("; {} {}", ties.size() == 1 ? "a tie:" : "ties:", fmt::join(ties, ", "));
    findings.push_back(fmt::format("{}; {} of {} behind.", text, behind, all));
  }
  return findings;
}

cli::Json contest_table(const cli::Json& report) {
  const cli::Json* gpvc = gpvc_of(report);
  if (gpvc == nullptr) return nullptr;
  std::vector<const Metric*> known;
  for (const Metric& metric : kMetrics)
    for (const cli::Json& mode : report["modes"])
      if (mode["epsilon"].is_number() && metric.of(mode, *gpvc) && (known.empty() || known.back() != &metric))
        known.push_back(&metric);
  if (known.empty()) return nullptr;
  cli::Json columns = cli::Json::array({"mode"}), rows = cli::Json::array();
  for (const Metric* metric : known) columns.push_back(metric->heading);
  for (const cli::Json& mode : report["modes"]) {
    if (!mode["epsilon"].is_number()) continue;
    cli::Json row = cli::Json::array({mode["name"]});
    for (const Metric* metric : known) {
      const std::optional<Result> result = metric->of(mode, *gpvc);
      row.push_back(result ? printed(*result, *metric) : std::string());
    }
    rows.push_back(row);
  }
  return {{"title", "Every bias against gpvc"},
          {"note",
           "How far each mode is ahead of gpvc (+) or behind it (-), and one standard error. Differences within two "
           "standard errors are ties. For texture, the error is that of the paired differences between faces, taking "
           "each face's sample points as a random sample; for renders, that of the paired differences between the 8 x "
           "8 tiles of each scored view. Classes are counted completely and have no sampling error."},
          {"columns", columns},
          {"rows", rows}};
}

}  // namespace gpvc::compare
