#include "app/pipeline/view_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <variant>

namespace gpvc::pipeline {

bool is_sound(const ViewRule& rule, std::size_t views) {
  const auto* ground = std::get_if<io::GroundRegion>(&rule.region);
  const auto is_finite = [](const auto& corner) { return std::isfinite(corner[0]) && std::isfinite(corner[1]); };
  return (ground == nullptr || (ground->corners.size() >= 3 && std::ranges::all_of(ground->corners, is_finite))) &&
         std::ranges::all_of(rule.views, [&](ViewId view) { return index(view) < views; });
}

ViewRuleTable::ViewRuleTable(std::span<const ViewRule> rules, const Mesh& mesh, std::size_t views)
    : set_of_face_(mesh.faces.size(), 0), allowed_{std::vector<bool>(views, true)} {
  const io::FaceLocator locator(mesh);
  for (const ViewRule& rule : rules) {
    std::vector<bool> left(views, !rule.allow);
    for (const ViewId view : rule.views) left[index(view)] = rule.allow;
    const std::vector<std::uint32_t> inside = locator.faces_in(rule.region);
    faces_of_rules_.push_back(inside.size());
    std::map<std::uint32_t, std::uint32_t> with_rule;  // the set of rules that this one makes of another
    for (const std::uint32_t f : inside) {
      const auto [made, fresh] = with_rule.try_emplace(set_of_face_[f], static_cast<std::uint32_t>(allowed_.size()));
      if (fresh) {
        std::vector<bool> both = allowed_[set_of_face_[f]];
        for (std::size_t v = 0; v < views; ++v) both[v] = both[v] && left[v];
        if (set_of_face_[f] != 0 && both == allowed_[set_of_face_[f]])
          made->second = set_of_face_[f];
        else
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
  std::vector<std::string> idle;
  for (std::size_t r = 0; r < rules.size(); ++r)
    if (table->faces_of_rules()[r] == 0) idle.push_back(rules[r].name);
  if (!idle.empty())
    observer.warning(fmt::format("{}: no face of the mesh lies in {}", results::readable_list(idle, 5),
                                 idle.size() == 1 ? "its region" : "their regions"));
  observer.figure("rules.faces", table->faces());
  observer.note(fmt::format("rules about photos apply to {} of {} faces", results::readable_count(table->faces()),
                            results::readable_count(mesh.faces.size())));
  return [table](FaceId face, ViewId view) { return table->allows(face, view); };
}

namespace {

// Numbers in any order, each any number of times.
NumberRanges ranges_of(std::vector<std::uint32_t> numbers) {
  std::ranges::sort(numbers);
  NumberRanges ranges;
  for (const std::uint32_t n : numbers) {
    if (!ranges.empty() && ranges.back()[1] + 1 >= n)
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
    const auto* listed = std::get_if<io::FaceRegion>(&rules[r].region);
    if (listed == nullptr) continue;
    std::vector<std::uint32_t> used;
    for (const auto& [first, last] : listed->ranges)
      for (std::size_t f = first; f <= last && f < mesh.faces.size(); ++f)
        used.insert(used.end(), mesh.faces[f].begin(), mesh.faces[f].end());
    all[r] = ranges_of(std::move(used));
  }
  return all;
}

std::vector<ViewRule> rules_of_part(std::span<const ViewRule> rules, std::span<const std::uint64_t> face) {
  return with_lists(rules, [&](std::size_t, const io::FaceRegion& listed) {
    std::vector<std::uint32_t> inside;
    for (const auto& [first, last] : listed.ranges)
      for (auto at = std::ranges::lower_bound(face, std::uint64_t{first}); at != face.end() && *at <= last; ++at)
        inside.push_back(static_cast<std::uint32_t>(at - face.begin()));
    return inside;
  });
}

std::vector<ViewRule> rules_of_coarser(std::span<const ViewRule> rules, std::span<const NumberRanges> listed,
                                       const Mesh& coarser, std::span<const std::uint32_t> vertex) {
  // By the finer mesh's number of their first corner.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> faces;
  for (std::uint32_t f = 0; f < coarser.faces.size(); ++f) faces.emplace_back(vertex[coarser.faces[f][0]], f);
  std::ranges::sort(faces);
  return with_lists(rules, [&](std::size_t r, const io::FaceRegion&) {
    const NumberRanges& ranges = listed[r];
    const auto is_listed = [&](std::uint32_t v) {
      const auto after = std::ranges::upper_bound(ranges, vertex[v], {}, [](const auto& range) { return range[0]; });
      return after != ranges.begin() && vertex[v] <= (*std::prev(after))[1];
    };
    std::vector<std::uint32_t> inside;
    for (const auto& [first, last] : ranges)
      for (auto at = std::ranges::lower_bound(faces, std::pair(first, std::uint32_t{0}));
           at != faces.end() && at->first <= last; ++at)
        if (std::ranges::all_of(coarser.faces[at->second], is_listed)) inside.push_back(at->second);
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
