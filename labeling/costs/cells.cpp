#include "labeling/costs/cells.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

namespace gpvc::labeling {
namespace {

/// Per face, the mean number of pixels that views show of it; 0 if none sees it whole.
std::vector<float> mean_pixels(const RecordsByView& by_view, std::size_t faces) {
  std::vector<float> pixels(faces, 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, faces, kChunkFaces), [&](const auto& range) {
    std::vector<float> views(range.size(), 0);
    for (const auto& [view, records] : by_view)
      for (auto record = std::ranges::lower_bound(records, range.begin(), {}, &FaceRecord::face);
           record != records.end() && record->face < range.end(); ++record) {
        if (!record->is_full()) continue;
        pixels[record->face] += static_cast<float>(std::max<std::uint16_t>(record->pixels, 1));
        views[record->face - range.begin()] += 1;
      }
    for (std::size_t face = range.begin(); face != range.end(); ++face)
      pixels[face] /= std::max(views[face - range.begin()], 1.0F);
  });
  return pixels;
}

/// Weighted by pixels.
struct ColorSum {
  double weight = 0;
  std::array<double, 3> rgb{};
  void add(double w, const std::array<float, 3>& color) {
    weight += w;
    for (std::size_t c = 0; c < 3; ++c) rgb[c] += w * static_cast<double>(color[c]);
  }
};

class SightMaker {
 public:
  SightMaker(const Grouped<std::uint32_t>& faces_of_cell, const PhotoColors& colors)
      : faces_(faces_of_cell), colors_(colors) {}

  /// The cells that the view sees half of the faces of, ascending.
  std::vector<std::uint32_t> seen_cells(std::span<const FaceRecord> records,
                                        std::span<const std::uint32_t> cell_of_face) const {
    std::vector<std::uint32_t> shown(faces_.groups(), 0), seen;
    for (const FaceRecord& record : records)
      if (record.is_full()) ++shown[cell_of_face[record.face]];
    for (std::uint32_t cell = 0; cell < shown.size(); ++cell)
      if (is_seen(shown[cell], cell)) seen.push_back(cell);
    return seen;
  }
  /// Calls body(sight) for each of seen_cells(), in their order.
  template <class Body>
  void for_each_sight(std::uint32_t view, std::span<const FaceRecord> records,
                      std::span<const std::uint32_t> cell_of_face, const Body& body) const {
    Grouped<std::uint32_t> of_cell;
    group_items_into(of_cell, faces_.groups(), [&](const auto& add) {
      for (std::uint32_t i = 0; i < records.size(); ++i)
        if (records[i].is_full()) add(cell_of_face[records[i].face], i);
    });
    for (std::uint32_t cell = 0; cell < of_cell.groups(); ++cell)
      if (is_seen(of_cell[cell].size(), cell)) body(sight(view, records, of_cell[cell], faces_[cell]));
  }

 private:
  bool is_seen(std::size_t shown, std::uint32_t cell) const { return shown > 0 && 2 * shown >= faces_[cell].size(); }

  CellSight sight(std::uint32_t view, std::span<const FaceRecord> records, std::span<const std::uint32_t> shown,
                  std::span<const std::uint32_t> faces) const {
    ColorSum all;
    std::array<ColorSum, kCellParts> parts;
    double brightness = 0, squares = 0, steps = 0;
    for (const std::uint32_t i : shown) {
      const FaceRecord& record = records[i];
      const std::array<float, 3> rgb = colors_.rgb(view, record);
      const double weight = std::max<std::uint16_t>(record.pixels, 1), contrast = record.contrast / 256.0;
      const double level = static_cast<double>(rgb[0] + 2 * rgb[1] + rgb[2]) / 4;
      all.add(weight, rgb);
      brightness += weight * level;
      squares += weight * (level * level + contrast * contrast);
      const double step = record.steps() / 256.0;
      steps += weight * step * step;
      const auto place = static_cast<std::size_t>(std::ranges::lower_bound(faces, record.face) - faces.begin());
      parts[place * std::min(kCellParts, faces.size()) / faces.size()].add(weight, rgb);
    }
    CellSight result;
    result.view = view;
    result.pixels = static_cast<float>(all.weight);
    result.steps = static_cast<float>(steps / all.weight);
    const double mean = brightness / all.weight;
    const double contrast = std::sqrt(std::max(0.0, squares / all.weight - mean * mean));
    result.log_contrast = std::log2(kNoContrast + static_cast<float>(contrast));
    for (std::size_t c = 0; c < 3; ++c) result.rgb[c] = static_cast<float>(all.rgb[c] / all.weight);
    for (std::size_t p = 0; p < kCellParts; ++p)
      if (parts[p].weight > 0) add_part(p, parts[p], result);
    return result;
  }

  static void add_part(std::size_t part, const ColorSum& sum, CellSight& result) {
    result.shown = static_cast<std::uint8_t>(result.shown | 1U << part);
    ++result.shown_parts;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto level = static_cast<std::uint8_t>(std::clamp(sum.rgb[c] / sum.weight + 0.5, 0.0, 255.0));
      result.parts[part][c] = level;
      result.part_levels[c] = static_cast<std::uint16_t>(result.part_levels[c] + level);
      result.part_squares += std::uint32_t{level} * level;
    }
  }

  const Grouped<std::uint32_t>& faces_;  ///< by cell, ascending
  const PhotoColors& colors_;
};

/// Leaves kMostSights of each cell.
void drop_small_sights(Grouped<CellSight>& sights) {
  std::size_t end = 0;
  for (std::size_t cell = 0; cell < sights.groups(); ++cell) {
    const std::span<CellSight> all(sights.items.data() + sights.first[cell],
                                   sights.items.data() + sights.first[cell + 1]);
    const std::span<CellSight> left = all.first(std::min(all.size(), kMostSights));
    if (left.size() < all.size()) {
      std::ranges::nth_element(all, all.begin() + kMostSights, [](const CellSight& a, const CellSight& b) {
        return std::tuple(b.pixels, a.view) < std::tuple(a.pixels, b.view);
      });
      std::ranges::sort(left, {}, &CellSight::view);
    }
    std::ranges::copy(left, sights.items.begin() + static_cast<std::ptrdiff_t>(end));
    sights.first[cell] = end;
    end += left.size();
  }
  sights.first.back() = end;
  sights.items.resize(end);
}

}  // namespace

Clusters make_clusters(const Grouped<std::uint32_t>& neighbours, std::span<const float> sizes, float wanted) {
  Clusters result;
  std::vector<std::uint32_t>& of_node = result.of_node;
  of_node.assign(neighbours.groups(), kNoCell);
  std::vector<std::uint32_t> members;
  for (std::uint32_t seed = 0; seed < of_node.size(); ++seed) {
    if (of_node[seed] != kNoCell || !(sizes[seed] > 0)) continue;
    members.assign(1, seed);
    of_node[seed] = result.count;
    float sum = sizes[seed];
    std::uint32_t other = kNoCell;
    for (std::size_t i = 0; i < members.size() && sum < wanted; ++i)
      for (const std::uint32_t beside : neighbours[members[i]]) {
        if (of_node[beside] != kNoCell && of_node[beside] != result.count) other = of_node[beside];
        if (of_node[beside] != kNoCell || !(sizes[beside] > 0) || !(sum < wanted)) continue;
        of_node[beside] = result.count;
        sum += sizes[beside];
        members.push_back(beside);
      }
    if (2 * sum < wanted && other != kNoCell)
      for (const std::uint32_t node : members) of_node[node] = other;
    else
      ++result.count;
  }
  return result;
}

Grouped<std::uint32_t> clusters_beside(const Clusters& clusters, const Grouped<std::uint32_t>& neighbours) {
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (std::uint32_t node = 0; node < neighbours.groups(); ++node) {
    const std::uint32_t mine = clusters.of_node[node];
    if (mine == kNoCell) continue;
    for (const std::uint32_t beside : neighbours[node])
      if (const std::uint32_t other = clusters.of_node[beside]; other != kNoCell && mine < other)
        pairs.push_back({mine, other});
  }
  tbb::parallel_sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return group_neighbours(clusters.count, pairs);
}

Cells make_cells(const RecordsByView& by_view, const PhotoColors& colors, const Grouped<std::uint32_t>& neighbours) {
  Cells cells;
  Clusters clusters = make_clusters(neighbours, mean_pixels(by_view, neighbours.groups()), kCellPixels);
  cells.beside = clusters_beside(clusters, neighbours);
  cells.of_face = std::move(clusters.of_node);
  const auto faces_of_cell = group_items<std::uint32_t>(clusters.count, [&](const auto& add) {
    for (std::uint32_t face = 0; face < cells.of_face.size(); ++face)
      if (cells.of_face[face] != kNoCell) add(cells.of_face[face], face);
  });
  std::vector<std::pair<std::uint32_t, const std::vector<FaceRecord>*>> views;
  for (const auto& [view, records] : by_view) views.emplace_back(view, &records);
  const SightMaker maker(faces_of_cell, colors);
  std::vector<std::vector<std::uint32_t>> places(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(),
                    [&](std::size_t v) { places[v] = maker.seen_cells(*views[v].second, cells.of_face); });
  // A view's cells, then where its sights of them go.
  std::vector<std::size_t>& first = cells.sights.first;
  first.assign(std::size_t{clusters.count} + 1, 0);
  for (const auto& of_view : places)
    for (const std::uint32_t cell : of_view) ++first[cell + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  cells.sights.items.resize(first.back());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (auto& of_view : places)
    for (std::uint32_t& place : of_view) place = static_cast<std::uint32_t>(next[place]++);
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t v) {
    std::size_t n = 0;
    maker.for_each_sight(views[v].first, *views[v].second, cells.of_face,
                         [&](const CellSight& sight) { cells.sights.items[places[v][n++]] = sight; });
  });
  drop_small_sights(cells.sights);
  return cells;
}

}  // namespace gpvc::labeling
