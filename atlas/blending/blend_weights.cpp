#include "atlas/blending/blend_weights.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace gpvc::atlas {

namespace {

/// The main view's weight from which on its coarse colour is trusted fully.
constexpr float kTrusted = 0.6f;
/// The part of the difference from the views' mean that is added. The mean alone would flatten what photos show in
/// different places, such as leaves, while detail that is finer keeps its contrast. Of 0.5, 0.6 and 1 this has the least
/// error on photos held out of three scenes (benchmarks/README.md).
constexpr float kPart = 0.6f;

/// Adds the views of a face that weigh something.
void begin_with(const labeling::CostTable& table, std::uint32_t face, double full_cost, std::vector<BlendView>& list) {
  const auto views = table.views_of(face);
  const auto costs = table.costs_of(face);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double weight = 1 - static_cast<double>(costs[i]) / full_cost;
    if (weight > 0) list.push_back({views[i], static_cast<float>(weight)});
  }
}

/// Lowers weights to those of a face, and removes the views that have none there.
void lower_to(const labeling::CostTable& table, std::uint32_t face, double full_cost, std::vector<BlendView>& list) {
  const auto views = table.views_of(face);
  const auto costs = table.costs_of(face);
  std::size_t kept = 0, i = 0;
  for (const BlendView& item : list) {
    while (i < views.size() && views[i] < item.view) ++i;
    if (i == views.size() || views[i] != item.view) continue;
    const double weight = 1 - static_cast<double>(costs[i]) / full_cost;
    if (weight > 0) list[kept++] = {item.view, std::min(item.weight, static_cast<float>(weight))};
  }
  list.resize(kept);
}

}  // namespace

BlendWeights::BlendWeights(const AtlasInput& input, double full_cost) {
  if (input.candidates.faces() != input.mesh.faces.size()) return;  // the caller has none
  const std::size_t vertices = input.mesh.positions.size();
  const Grouped<std::uint32_t> around = group_items<std::uint32_t>(vertices, [&](const auto& add) {
    for (std::uint32_t face = 0; face < input.mesh.faces.size(); ++face)
      for (const std::uint32_t vertex : input.mesh.faces[face]) add(vertex, face);
  });
  const auto views_at = [&](std::size_t vertex, std::vector<BlendView>& list) {
    list.clear();
    const std::span<const std::uint32_t> faces = around[vertex];
    const auto whole = [&](std::uint32_t face) { return input.tags[face] == labeling::FaceTag::seen; };
    if (faces.empty() || !std::ranges::all_of(faces, whole)) return;
    begin_with(input.candidates, faces[0], full_cost, list);
    for (const std::uint32_t face : faces.subspan(1)) lower_to(input.candidates, face, full_cost, list);
    if (list.size() < 2) list.clear();
  };
  // Lists are made twice, to count and to fill.
  using Range = tbb::blocked_range<std::size_t>;
  constexpr std::size_t kGrain = 4096;
  views_.first.assign(vertices + 1, 0);
  tbb::parallel_for(Range(0, vertices, kGrain), [&](const Range& range) {
    std::vector<BlendView> list;
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      views_at(v, list);
      views_.first[v + 1] = list.size();
    }
  });
  for (std::size_t v = 0; v < vertices; ++v) views_.first[v + 1] += views_.first[v];
  views_.items.resize(views_.first.back());
  tbb::parallel_for(Range(0, vertices, kGrain), [&](const Range& range) {
    std::vector<BlendView> list;
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      if (views_[v].empty()) continue;
      views_at(v, list);
      std::ranges::copy(list, views_[v].begin());
    }
  });
}

float BlendWeights::factor(std::uint32_t vertex, std::uint32_t view, std::uint32_t main) const {
  float sum = 0, mine = 0, of_main = 0;
  for (const BlendView& item : at(vertex)) {
    sum += item.weight;
    if (item.view == view) mine = item.weight;
    if (item.view == main) of_main = item.weight;
  }
  if (!(of_main > 0) || !(mine > 0)) return 0;
  const float trust = std::min(1.0f, of_main / kTrusted);
  return kPart * trust * (mine / sum - (view == main ? 1.0f : 0.0f));
}

}  // namespace gpvc::atlas
