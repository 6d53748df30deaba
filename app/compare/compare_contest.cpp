// Modes with a bias beside gpvc, metric by metric: which is better, and which differences may be chance.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

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
  const char *name, *heading;
  double factor;    ///< of the printed numbers
  const char* key;  ///< in "against_gpvc"; nullptr: the oracle's agreement
};
constexpr Metric kMetrics[] = {{"seen area textured rightly", "Textured rightly, points", 100, "right"},
                               {"area textured faithfully", "Textured faithfully, points", 100, "faithful"},
                               {"classes that agree with the oracle", "Oracle, points", 100, nullptr},
                               {"error of renders", "1 - NCC, less by", 1, "error"}};

std::optional<Result> result_of(const Json& mode, const Json& gpvc, const Metric& metric) {
  if (metric.key == nullptr) {
    const auto theirs = number_at(mode, "oracle.agreement"), ours = number_at(gpvc, "oracle.agreement");
    return theirs && ours ? std::optional(Result{*theirs - *ours, std::nullopt}) : std::nullopt;
  }
  const std::string path = fmt::format("against_gpvc.{}", metric.key);
  const auto ahead = number_at(mode, path + ".ahead");
  return ahead ? std::optional(Result{*ahead, number_at(mode, path + ".noise")}) : std::nullopt;
}

std::string printed(const Result& result, const Metric& metric) {
  const char* words[] = {"behind", "tie", "ahead"};
  std::string text = fmt::format("{:+.4f}", metric.factor * result.ahead);
  if (result.noise) text += fmt::format(" ± {:.4f}", metric.factor * *result.noise);
  return text + ", " + words[static_cast<std::size_t>(result.standing())];
}

// gpvc, if it did not fail; else nullptr.
const Json* finished_gpvc(const Json& report) {
  const Json* gpvc = mode_called(report, "gpvc");
  return gpvc != nullptr && (*gpvc)["status"] == "ok" ? gpvc : nullptr;
}

}  // namespace

std::vector<std::string> contest_findings(const Json& report) {
  std::vector<std::string> findings;
  const Json* gpvc = finished_gpvc(report);
  if (gpvc == nullptr) return findings;
  for (const Metric& metric : kMetrics) {
    std::size_t counts[3] = {};  // by Standing
    for (const Json& mode : report["modes"]) {
      if (!mode["epsilon"].is_number() || mode["status"] != "ok") continue;
      if (const auto result = result_of(mode, *gpvc, metric)) ++counts[static_cast<std::size_t>(result->standing())];
    }
    const auto [behind, ties, ahead] = counts;
    if (behind + ties + ahead == 0) continue;
    findings.push_back(fmt::format(
        "By {}, {} of {} pairs of a mode and its epsilon {} ahead of gpvc, {} tie{} with it, and {} {} behind.",
        metric.name, ahead, behind + ties + ahead, ahead == 1 ? "is" : "are", ties, ties == 1 ? "s" : "", behind,
        behind == 1 ? "is" : "are"));
  }
  return findings;
}

Json contest_table(const Json& report) {
  const Json* gpvc = finished_gpvc(report);
  if (gpvc == nullptr) return nullptr;
  std::vector<const Metric*> known;
  for (const Metric& metric : kMetrics)
    for (const Json& mode : report["modes"])
      if (mode["epsilon"].is_number() && result_of(mode, *gpvc, metric) && (known.empty() || known.back() != &metric))
        known.push_back(&metric);
  if (known.empty()) return nullptr;
  Json columns = Json::array({"mode"}), rows = Json::array();
  for (const Metric* metric : known) columns.push_back(metric->heading);
  for (const Json& mode : report["modes"]) {
    if (!mode["epsilon"].is_number()) continue;
    Json row = Json::array({mode["name"]});
    for (const Metric* metric : known) {
      const std::optional<Result> result = result_of(mode, *gpvc, *metric);
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
