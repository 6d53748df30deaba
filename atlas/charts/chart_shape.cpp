#include "atlas/charts/chart_shape.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <vector>

namespace gpvc::atlas {

namespace {

/// Inclusive intervals of texels per row, ascending and apart from one another.
using Intervals = std::vector<std::pair<int, int>>;
using Rows = std::vector<Intervals>;

void unite(Intervals& list) {
  std::sort(list.begin(), list.end());
  std::size_t kept = 0;
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (list[i].first <= list[kept].second + 1)
      list[kept].second = std::max(list[kept].second, list[i].second);
    else
      list[++kept] = list[i];
  }
  if (!list.empty()) list.resize(kept + 1);
}

/// Texels within `margin` of those that faces touch, shifted by (margin, margin) so that none is negative.
Rows margin_rows(const Chart& chart, std::span<const TexelTriangle> corners, int margin) {
  const CellBox box{-margin, -margin, chart.width + margin, chart.height + margin};
  Rows rows(static_cast<std::size_t>(box.y1 - box.y0));
  if (chart.kind == ChartKind::unseen) {
    for (auto& row : rows) row.emplace_back(0, box.x1 - box.x0 - 1);
    return rows;
  }
  for (const auto face : chart.faces)
    triangle_spans(corners[face], margin + 0.5, box, [&](int y, int first, int last) {
      auto& row = rows[static_cast<std::size_t>(y - box.y0)];
      const std::pair<int, int> span(first - box.x0, last - box.x0);
      // Faces that follow each other mostly lie beside each other.
      if (!row.empty() && span.first <= row.back().second + 1 && row.back().first <= span.second + 1)
        row.back() = {std::min(row.back().first, span.first), std::max(row.back().second, span.second)};
      else
        row.push_back(span);
    });
  for (auto& row : rows) unite(row);
  return rows;
}

/// Rows of blocks after a shift of the texels by `down`. Intervals along x are still in texels.
Rows gather_rows(const Rows& rows, int down, int edge) {
  Rows gathered(static_cast<std::size_t>((static_cast<int>(rows.size()) + down + edge - 1) / edge));
  for (int y = 0; y < static_cast<int>(rows.size()); ++y) {
    const auto& row = rows[static_cast<std::size_t>(y)];
    auto& to = gathered[static_cast<std::size_t>((y + down) / edge)];
    to.insert(to.end(), row.begin(), row.end());
  }
  for (auto& row : gathered) unite(row);
  return gathered;
}

/// Calls visit(row, first block, last block) after a shift by `right`. The runs of a row ascend and are apart.
template <typename Visit>
void block_runs(const Rows& gathered, int right, int edge, const Visit& visit) {
  for (std::size_t y = 0; y < gathered.size(); ++y) {
    const auto& row = gathered[y];
    for (std::size_t i = 0; i < row.size();) {
      const int first = (row[i].first + right) / edge;
      int last = (row[i].second + right) / edge;
      for (++i; i < row.size() && (row[i].first + right) / edge <= last + 1; ++i) last = (row[i].second + right) / edge;
      visit(static_cast<int>(y), first, last);
    }
  }
}

}  // namespace

int block_edge(int padding) { return static_cast<int>(std::bit_floor(static_cast<unsigned>(std::max(1, padding)))); }

int block_margin(int padding) { return padding <= 0 ? 0 : std::max(1, block_edge(padding) / 4); }

ChartShape chart_shape(const Chart& chart, std::span<const TexelTriangle> corners, int padding, int page_size) {
  const int edge = block_edge(padding), margin = block_margin(padding), most = page_size / edge;
  const Rows rows = margin_rows(chart, corners, margin);
  const auto across = [edge](int texels) { return (texels + edge - 1) / edge; };
  ChartShape best;
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (int down = 0; down < edge; ++down) {
    if (down > 0 && across(static_cast<int>(rows.size()) + down) > most) break;
    const Rows gathered = gather_rows(rows, down, edge);
    for (int right = 0; right < edge; ++right) {
      if (right > 0 && across(chart.width + 2 * margin + right) > most) break;
      std::int64_t count = 0;
      block_runs(gathered, right, edge, [&](int, int first, int last) { count += last - first + 1; });
      if (count >= least) continue;
      least = count;
      best.inset_x = right + margin;
      best.inset_y = down + margin;
    }
  }
  const Rows gathered = gather_rows(rows, best.inset_y - margin, edge);
  best.blocks.height = static_cast<int>(gathered.size());
  best.blocks.width = across(chart.width + margin + best.inset_x);
  block_runs(gathered, best.inset_x - margin, edge, [&](int y, int first, int last) {
    best.blocks.runs.push_back({y, first, last - first + 1});
  });
  return best;
}

}  // namespace gpvc::atlas
