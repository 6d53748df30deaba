// What a report opens with: each mode at the epsilon that one would pick beforehand, and at the best one found afterwards.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "app/compare/compare_report.h"

namespace gpvc::compare {
namespace {

// What is known of a mode, in the order in which it matters.
constexpr const char* kOpeningMeasures[] = {"oracle.agreement", "truth.origin.all.right", "truth.origin.all.faithful",
                                            "score.one_minus_ncc"};

// The rays of mvs-texturing, the usual texturer, pass whatever is nearer to a face than this share of their length.
constexpr double kPickedShare = 1e-4;

/// The modes of a family; one mode where there is no epsilon.
struct Family {
  std::string name;
  std::vector<const Json*> modes;
  bool biased() const { return modes.front()->at("epsilon").is_number(); }
};

// gpvc comes first, the others in the report's order.
std::vector<Family> families_of(const Json& report) {
  std::vector<Family> families;
  for (const Json& mode : report["modes"]) {
    const auto same = [&](const Family& f) { return f.name == mode["family"]; };
    auto at = std::ranges::find_if(families, same);
    if (at == families.end()) at = families.insert(at, Family{mode["family"].get<std::string>(), {}});
    at->modes.push_back(&mode);
  }
  std::stable_partition(families.begin(), families.end(), [](const Family& f) { return f.name == "gpvc"; });
  return families;
}

std::vector<const Figure*> measures_of(const Json& report) {
  std::vector<const Figure*> measures;
  for (const char* path : kOpeningMeasures) {
    const auto same = [&](const Figure& figure) { return figure.path == std::string_view(path); };
    const auto known = [&](const Json& mode) { return number_at(mode, path).has_value(); };
    if (std::any_of(report["modes"].begin(), report["modes"].end(), known))
      measures.push_back(&*std::ranges::find_if(compared_figures(), same));
  }
  return measures;
}

const Json* picked(const Family& family) {
  const auto distance = [](const Json* mode) {
    const auto share = number_at(*mode, "depth_share");
    return share ? std::abs(std::log10(*share / kPickedShare)) : std::numeric_limits<double>::infinity();
  };
  return *std::ranges::min_element(family.modes, {}, distance);
}

/// The best mode by a figure and the worst; nullptr where none has it.
struct Ends {
  const Json *best = nullptr, *worst = nullptr;
};

Ends ends_of(const Family& family, const Figure& figure) {
  Ends ends;
  const auto better = [&](const Json& a, const Json* b) {
    return b == nullptr || figure.better * *number_at(a, figure.path) > figure.better * *number_at(*b, figure.path);
  };
  for (const Json* mode : family.modes) {
    if (!number_at(*mode, figure.path)) continue;
    if (better(*mode, ends.best)) ends.best = mode;
    if (ends.worst == nullptr || better(*ends.worst, mode)) ends.worst = mode;
  }
  return ends;
}

std::string epsilon_of(const Json& mode) { return fmt::format("{:g}", mode["epsilon"].get<double>()); }

}  // namespace

Json opening_table(const Json& report) {
  const std::vector<const Figure*> measures = measures_of(report);
  if (measures.empty()) return nullptr;
  Json columns = Json::array({"mode"}), rows = Json::array();
  for (const Figure* measure : measures)
    columns.push_back(fmt::format("{}{}{}", measure->name, *measure->unit ? ", " : "", measure->unit));
  for (const Family& family : families_of(report)) {
    const Json& before = *picked(family);
    Json row = Json::array(
        {family.biased() ? fmt::format("{}, picked beforehand: {}", family.name, epsilon_of(before)) : family.name});
    for (const Figure* measure : measures) row.push_back(printed_figure(number_at(before, measure->path), *measure));
    rows.push_back(std::move(row));
    if (!family.biased()) continue;
    Json after = Json::array({fmt::format("{}, best afterwards", family.name)});
    for (const Figure* measure : measures) {
      const Json* best = ends_of(family, *measure).best;
      after.push_back(
          best == nullptr
              ? ""
              : fmt::format("{} at {}", printed_figure(number_at(*best, measure->path), *measure), epsilon_of(*best)));
    }
    rows.push_back(std::move(after));
  }
  return {{"title", "What there is to pick"},
          {"note",
           "gpvc has no epsilon. Picked beforehand: of the epsilons tried, the one that comes nearest to bridging a "
           "ten-thousandth of the median depth, as the rays of mvs-texturing do. Best afterwards: for each measure the "
           "epsilon that has turned out best, which nobody knows without the truth."},
          {"columns", columns},
          {"rows", rows}};
}

Json best_and_worst(const Json& report) {
  Json all = Json::array();
  const std::vector<const Figure*> measures = measures_of(report);
  if (measures.empty()) return all;
  for (const Family& family : families_of(report)) {
    const Ends ends = ends_of(family, *measures.front());
    if (!family.biased() || ends.best == nullptr) continue;
    all.push_back({{"family", family.name},
                   {"by", measures.front()->name},
                   {"best", ends.best->at("name")},
                   {"worst", ends.worst->at("name")}});
  }
  return all;
}

}  // namespace gpvc::compare
