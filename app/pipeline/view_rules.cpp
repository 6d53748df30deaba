#include "app/pipeline/view_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <variant>

namespace gpvc::pipeline {

ViewRuleTable::ViewRuleTable(std::span<const ViewRule> rules, const Mesh& mesh, std::size_t views)
    : set_of_face_(mesh.faces.size(), 0), allowed_{std::vector<bool>(views, true)} {
  for (const ViewRule& rule : rules) {
    std::vector<bool> left(views, !rule.allow);
    for (const ViewId view : rule.views) left[index(view)] = rule.allow;
    const std::vector<std::uint8_t> inside = io::faces_in(rule.region, mesh);
    faces_of_rules_.push_back(static_cast<std::size_t>(std::ranges::count(inside, 1)));
    std::map<std::uint32_t, std::uint32_t> with_rule;  // the set of rules that this one makes of another
    for (std::size_t f = 0; f < inside.size(); ++f) {
      if (inside[f] == 0) continue;
      const auto [made, fresh] = with_rule.try_emplace(set_of_face_[f], static_cast<std::uint32_t>(allowed_.size()));
      if (fresh) {
        std::vector<bool> both = allowed_[set_of_face_[f]];
        for (std::size_t v = 0; v < views; ++v) both[v] = both[v] && left[v];
        allowed_.push_back(std::move(both));
      }
      set_of_face_[f] = made->second;
    }
  }
}

std::size_t ViewRuleTable::faces() const {
  return static_cast<std::size_t>(std::ranges::count_if(set_of_face_, [](std::uint32_t set) { return set != 0; }));
}

labeling::CandidateCollector::Allowed allowed_views(std::span<const ViewRule> rules, const Mesh& mesh,
                                                    std::size_t views, results::Observer& observer) {
  if (rules.empty()) return {};
  const auto table = std::make_shared<const ViewRuleTable>(rules, mesh, views);
  for (std::size_t r = 0; r < rules.size(); ++r)
    if (table->faces_of_rules()[r] == 0)
      observer.warning(fmt::format("{}: no face of the mesh lies in its region", rules[r].name));
  observer.figure("rules.faces", table->faces());
  observer.note(fmt::format("rules about photos apply to {} of {} faces", results::readable_count(table->faces()),
                            results::readable_count(mesh.faces.size())));
  return [table](FaceId face, ViewId view) { return table->allows(face, view); };
}

namespace {

// Of flags, the numbers of those that are set.
NumberRanges ranges_of(std::span<const std::uint8_t> flags) {
  NumberRanges ranges;
  for (std::uint32_t n = 0; n < flags.size(); ++n) {
    if (flags[n] == 0) continue;
    if (!ranges.empty() && ranges.back()[1] + 1 == n)
      ranges.back()[1] = n;
    else
      ranges.push_back({n, n});
  }
  return ranges;
}

// Calls list(rule number, region) for rules that list faces; returns the rules with what that gives instead.
template <typename List>
std::vector<ViewRule> with_lists(std::span<const ViewRule> rules, const List& list) {
  std::vector<ViewRule> changed(rules.begin(), rules.end());
  for (std::size_t r = 0; r < rules.size(); ++r)
    if (const auto* listed = std::get_if<io::FaceRegion>(&rules[r].region))
      changed[r].region = io::FaceRegion{ranges_of(list(r, *listed))};
  return changed;
}

}  // namespace

std::vector<NumberRanges> listed_vertices(std::span<const ViewRule> rules, const Mesh& mesh) {
  std::vector<NumberRanges> all(rules.size());
  for (std::size_t r = 0; r < rules.size(); ++r) {
    if (!std::holds_alternative<io::FaceRegion>(rules[r].region)) continue;
    const std::vector<std::uint8_t> inside = io::faces_in(rules[r].region, mesh);
    std::vector<std::uint8_t> used(mesh.positions.size(), 0);
    for (std::size_t f = 0; f < inside.size(); ++f)
      if (inside[f] != 0)
        for (const std::uint32_t v : mesh.faces[f]) used[v] = 1;
    all[r] = ranges_of(used);
  }
  return all;
}

std::vector<ViewRule> rules_of_part(std::span<const ViewRule> rules, std::span<const std::uint64_t> face) {
  return with_lists(rules, [&](std::size_t, const io::FaceRegion& listed) {
    std::vector<std::uint8_t> inside(face.size(), 0);
    for (const auto& [first, last] : listed.ranges)
      for (auto at = std::ranges::lower_bound(face, std::uint64_t{first}); at != face.end() && *at <= last; ++at)
        inside[static_cast<std::size_t>(at - face.begin())] = 1;
    return inside;
  });
}

std::vector<ViewRule> rules_of_coarser(std::span<const ViewRule> rules, std::span<const NumberRanges> listed,
                                       const Mesh& coarser, std::span<const std::uint32_t> vertex) {
  return with_lists(rules, [&](std::size_t r, const io::FaceRegion&) {
    const NumberRanges& ranges = listed[r];
    const auto is_listed = [&](std::uint32_t v) {
      const auto after = std::ranges::upper_bound(ranges, vertex[v], {}, [](const auto& range) { return range[0]; });
      return after != ranges.begin() && vertex[v] <= (*std::prev(after))[1];
    };
    std::vector<std::uint8_t> inside(coarser.faces.size(), 0);
    for (std::size_t f = 0; f < inside.size(); ++f)
      inside[f] = std::ranges::all_of(coarser.faces[f], is_listed) ? 1 : 0;
    return inside;
  });
}

void report_refused(std::span<const FaceId> refused, results::Observer& observer) {
  observer.figure("rules.faces_without_views", refused.size());
  if (!refused.empty())
    observer.warning(
        fmt::format("{} faces are filled, the first of them face {}: the rules refuse all photos that see them",
                    results::readable_count(refused.size()), index(refused.front())));
}

}  // namespace gpvc::pipeline
