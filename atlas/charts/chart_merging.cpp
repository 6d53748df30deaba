#include "atlas/charts/chart_merging.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

#include "atlas/charts/texel_set.h"
#include "io/image.h"

namespace gpvc::atlas {

namespace {

constexpr int kCell = 4;  ///< texels, edge of the cells in which closeness is judged
constexpr std::uint32_t kFree = 0xFFFFFFFFu;

/// Merges the parts of one view, scale and tile.
class ViewMerger {
 public:
  ViewMerger(std::vector<FramePart>& parts, std::span<const std::uint32_t> mine, std::span<const TexelTriangle> corners,
             const MergeRule& rule)
      : parts_(parts), mine_(mine), corners_(corners), rule_(rule), parent_(mine.size()) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    if (rule.sharing == TexelSharing::allowed) return;
    covered_.resize(mine.size());
    for (std::size_t k = 0; k < mine.size(); ++k)
      for (const auto face : parts[mine[k]].faces)
        covered_spans(corners[face], [&](int y, int first, int last) { covered_[k].add(y, first, last); });
  }

  /// Faces move to the first part of each union; the other parts are left empty.
  void merge() {
    mark_cells();
    for (std::uint32_t k = 0; k < mine_.size(); ++k) {
      const std::uint32_t r = root(k);
      if (r == k) continue;
      auto& to = parts_[mine_[r]].faces;
      auto& from = parts_[mine_[k]].faces;
      to.insert(to.end(), from.begin(), from.end());
      from.clear();
    }
    for (const auto p : mine_) std::sort(parts_[p].faces.begin(), parts_[p].faces.end());
  }

 private:
  /// Every part marks the cells within its closeness; parts that meet in a cell are united.
  void mark_cells() {
    const int closeness = rule_.closeness;
    FrameBox all;
    for (const auto p : mine_) all.add(parts_[p].box);
    const double x0 = all.x0 - closeness - kCell, y0 = all.y0 - closeness - kCell;
    const CellBox grid{0, 0, static_cast<int>((all.x1 - x0 + closeness) / kCell) + 2,
                       static_cast<int>((all.y1 - y0 + closeness) / kCell) + 2};
    std::vector<std::uint32_t> owner(pixel_index(0, grid.y1, grid.x1), kFree);
    const double half = (closeness + kCell / 2.0) / kCell;
    for (std::uint32_t k = 0; k < mine_.size(); ++k) {
      for (const auto face : parts_[mine_[k]].faces) {
        TexelTriangle t = corners_[face];
        for (auto& p : t) p = {(p.x - x0) / kCell, (p.y - y0) / kCell};
        triangle_spans(t, half, grid, [&](int y, int first, int last) {
          for (int x = first; x <= last; ++x) {
            auto& cell = owner[pixel_index(x, y, grid.x1)];
            if (cell == kFree)
              cell = k;
            else if (cell != k)
              unite(cell, k);
          }
        });
      }
    }
  }

  std::uint32_t root(std::uint32_t k) {
    while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
    return k;
  }

  void unite(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (a == b) return;
    if (a > b) std::swap(a, b);
    if (refused_.contains({a, b})) return;
    FrameBox box = parts_[mine_[a]].box;
    box.add(parts_[mine_[b]].box);
    if (!rule_.fits(box) || !disjoint(a, b)) {
      refused_.emplace(a, b);
      return;
    }
    parent_[b] = a;
    parts_[mine_[a]].box = box;
    if (!covered_.empty()) covered_[a].take(covered_[b]);
  }

  bool disjoint(std::uint32_t a, std::uint32_t b) const { return covered_.empty() || !covered_[a].meets(covered_[b]); }

  std::vector<FramePart>& parts_;
  std::span<const std::uint32_t> mine_;
  std::span<const TexelTriangle> corners_;
  const MergeRule& rule_;
  std::vector<std::uint32_t> parent_;
  std::vector<TexelSet> covered_;  ///< empty where texels may be shared
  std::set<std::pair<std::uint32_t, std::uint32_t>> refused_;
};

}  // namespace

std::vector<FramePart> merge_close_parts(std::vector<FramePart> parts, std::span<const TexelTriangle> corners,
                                         const MergeRule& rule) {
  std::vector<std::uint32_t> order(parts.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t p) { return std::tuple(parts[p].view, parts[p].scale, parts[p].tile); };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return key(a) < key(b); });
  std::vector<std::span<const std::uint32_t>> views;
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    while (last < order.size() && key(order[last]) == key(order[first])) ++last;
    views.push_back(std::span<const std::uint32_t>(order).subspan(first, last - first));
    first = last;
  }
  tbb::parallel_for(std::size_t{0}, views.size(),
                    [&](std::size_t v) { ViewMerger(parts, views[v], corners, rule).merge(); });
  std::erase_if(parts, [](const FramePart& part) { return part.faces.empty(); });
  std::sort(parts.begin(), parts.end(),
            [](const FramePart& a, const FramePart& b) { return a.faces.front() < b.faces.front(); });
  return parts;
}

}  // namespace gpvc::atlas
