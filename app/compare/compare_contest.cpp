// Whether a mode with a bias wins against gpvc by any measure, and where a difference is no more than chance.
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "app/compare/compare_report.h"

namespace gpvc::compare {
namespace {

// Differences below so many standard errors are called ties: chance alone exceeds them in one of twenty.
constexpr double kSure = 2;

enum class Standing { behind, tie, ahead };

struct Result {
  double ahead = 0;
  std::optional<double> noise;  ///< one standard error; none where every pair was counted
  Standing standing() const {
    if (std::abs(ahead) <= kSure * noise.value_or(0)) return Standing::tie;
    return ahead > 0 ? Standing::ahead : Standing::behind;
  }
};

struct Discipline {
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

const Discipline kDisciplines[] = {
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

std::string printed(const Result& result, const Discipline& discipline) {
  const char* words[] = {"behind", "tie", "ahead"};
  std::string text = fmt::format("{:+.{}f}", discipline.factor * result.ahead, discipline.digits);
  if (result.noise) text += fmt::format(" ± {:.{}f}", discipline.factor * *result.noise, discipline.digits);
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
  for (const Discipline& discipline : kDisciplines) {
    std::vector<std::string> ahead, ties;
    std::size_t behind = 0;
    for (const cli::Json& mode : report["modes"]) {
      if (!mode["epsilon"].is_number() || mode["status"] != "ok") continue;
      const std::optional<Result> result = discipline.of(mode, *gpvc);
      if (!result) continue;
      const std::string name = mode["name"];
      if (result->standing() == Standing::behind) ++behind;
      if (result->standing() == Standing::tie) ties.push_back(name);
      if (result->standing() == Standing::ahead)
        ahead.push_back(fmt::format("{} ({})", name, printed(*result, discipline)));
    }
    const std::size_t all = ahead.size() + ties.size() + behind;
    if (all == 0) continue;
    std::string text = ahead.empty()
                           ? fmt::format("By {} no mode with a bias is ahead of gpvc at any epsilon", discipline.name)
                           : fmt::format("By {} ahead of gpvc: {}", discipline.name, fmt::join(ahead, ", "));
    if (!ties.empty()) text += fmt::format("; {} {}", ties.size() == 1 ? "a tie:" : "ties:", fmt::join(ties, ", "));
    findings.push_back(fmt::format("{}; {} of {} behind.", text, behind, all));
  }
  return findings;
}

cli::Json contest_table(const cli::Json& report) {
  const cli::Json* gpvc = gpvc_of(report);
  if (gpvc == nullptr) return nullptr;
  std::vector<const Discipline*> held;
  for (const Discipline& discipline : kDisciplines)
    for (const cli::Json& mode : report["modes"])
      if (mode["epsilon"].is_number() && discipline.of(mode, *gpvc) && (held.empty() || held.back() != &discipline))
        held.push_back(&discipline);
  if (held.empty()) return nullptr;
  cli::Json columns = cli::Json::array({"mode"}), rows = cli::Json::array();
  for (const Discipline* discipline : held) columns.push_back(discipline->heading);
  for (const cli::Json& mode : report["modes"]) {
    if (!mode["epsilon"].is_number()) continue;
    cli::Json row = cli::Json::array({mode["name"]});
    for (const Discipline* discipline : held) {
      const std::optional<Result> result = discipline->of(mode, *gpvc);
      row.push_back(result ? printed(*result, *discipline) : std::string());
    }
    rows.push_back(row);
  }
  return {{"title", "Every bias against gpvc"},
          {"note",
           "How far each mode is ahead of gpvc (+) or behind it (-), one standard error, and what follows: "
           "within "
           "two standard errors is a tie. Texture: the differences of the faces, as if each face's sample points "
           "were drawn anew. Renders: the paired differences over 8 x 8 tiles of each scored view, as if tiles "
           "were "
           "drawn from many. Classes are counted, all of them: no chance in it."},
          {"columns", columns},
          {"rows", rows}};
}

}  // namespace gpvc::compare
