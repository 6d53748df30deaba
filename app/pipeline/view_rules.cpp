#include "app/pipeline/view_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>

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

void report_refused(std::span<const FaceId> refused, results::Observer& observer) {
  observer.figure("rules.faces_without_views", refused.size());
  if (!refused.empty())
    observer.warning(
        fmt::format("{} faces are filled, the first of them face {}: the rules refuse all photos that see them",
                    results::readable_count(refused.size()), index(refused.front())));
}

}  // namespace gpvc::pipeline
