#include "atlas/blending/blend_weights.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "atlas/charts/flat_chart.h"
#include "io/freed_memory.h"

namespace gpvc::atlas {

namespace {

/// The main view's weight from which on its coarse colour is trusted fully.
constexpr float kTrusted = 0.6f;

/// Adds the views of a face that weigh something; their share is that weight, for now.
void begin_with(const labeling::CostTable& table, std::uint32_t face, double full_cost, std::vector<BlendView>& list) {
  const auto views = table.views_of(face);
  const auto costs = table.costs_of(face);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double weight = 1 - static_cast<double>(costs[i]) / full_cost;
    if (weight > 0) list.push_back({views[i], static_cast<float>(weight), 0, 0});
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
    if (weight > 0) list[kept++] = {item.view, std::min(item.share, static_cast<float>(weight)), 0, 0};
  }
  list.resize(kept);
}

/// Finds where the photo shows a vertex. False where it does not: a view sees a face whole if it sees the centres of all of its
/// pixels, so a vertex may lie beyond where its lens ends.
bool place(const View& view, const WorldPoint& p, BlendView& item) {
  const auto q = photo_from_world(view, p);
  if (!q) return false;
  item.x = static_cast<float>(q->x);
  item.y = static_cast<float>(q->y);
  return true;
}

}  // namespace

BlendWeights::BlendWeights(const AtlasInput& input, double full_cost) {
  if (input.candidates.faces() != input.mesh.faces.size()) return;  // the caller has none
  const std::size_t vertices = input.mesh.positions.size();
  const Grouped<std::uint32_t> around = group_items<std::uint32_t>(vertices, [&](const auto& add) {
    for (std::uint32_t face = 0; face < input.mesh.faces.size(); ++face)
      for (const std::uint32_t vertex : input.mesh.faces[face]) add(vertex, face);
  });
  // Faces that are textured as photos show them whole. Those that perspective bends have texels of their own, which are not
  // blended, so what is blended beside them fades towards them.
  std::vector<std::uint8_t> blended(input.mesh.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(blended.size())),
                    [&](const auto& range) {
                      for (std::uint32_t face = range.begin(); face < range.end(); ++face)
                        blended[face] = input.tags[face] == labeling::FaceTag::seen && !is_bent(input, face);
                    });
  const auto find_views = [&](std::size_t vertex, std::vector<BlendView>& list) {
    list.clear();
    const std::span<const std::uint32_t> faces = around[vertex];
    if (faces.empty() || !std::ranges::all_of(faces, [&](std::uint32_t face) { return blended[face] != 0; })) return;
    begin_with(input.candidates, faces[0], full_cost, list);
    for (const std::uint32_t face : faces.subspan(1)) lower_to(input.candidates, face, full_cost, list);
    std::erase_if(list, [&](BlendView& item) {
      return !place(input.scene.views[item.view], input.mesh.positions[vertex], item);
    });
    if (list.size() < 2) list.clear();
    float sum = 0;
    for (const BlendView& item : list) sum += item.share;
    for (BlendView& item : list) item.share /= sum;
    sums_[vertex] = sum;
  };
  // Chunks of vertices are worked on side by side, and joined.
  constexpr std::size_t kChunk = 4096;
  std::vector<std::vector<BlendView>> parts((vertices + kChunk - 1) / kChunk);
  views_.first.assign(vertices + 1, 0);
  sums_.assign(vertices, 0);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t chunk) {
    std::vector<BlendView> list;
    for (std::size_t v = chunk * kChunk; v < std::min(vertices, (chunk + 1) * kChunk); ++v) {
      find_views(v, list);
      views_.first[v + 1] = list.size();
      parts[chunk].insert(parts[chunk].end(), list.begin(), list.end());
    }
  });
  for (std::size_t v = 0; v < vertices; ++v) views_.first[v + 1] += views_.first[v];
  views_.items.reserve(views_.first.back());
  for (std::vector<BlendView>& part : parts) {
    views_.items.insert(views_.items.end(), part.begin(), part.end());
    free_memory(part);
  }
}

BlendWeights::Share BlendWeights::share(std::uint32_t vertex, std::uint32_t view, std::uint32_t main) const {
  const BlendView *mine = nullptr, *of_main = nullptr;
  for (const BlendView& item : at(vertex)) {
    if (item.view == view) mine = &item;
    if (item.view == main) of_main = &item;
  }
  if (mine == nullptr || of_main == nullptr) return {0, mine};
  const float trust = std::min(1.0f, weight(vertex, *of_main) / kTrusted);
  return {kBlendedPart * trust * (mine->share - (view == main ? 1.0f : 0.0f)), mine};
}

}  // namespace gpvc::atlas
