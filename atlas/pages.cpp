#include "atlas/pages.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>

namespace gpvc {

namespace {

/// Per texel a colour and whether it is filled, of a mip level.
struct MipLevel {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint8_t> filled;
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// Box reduction over the filled texels; `color` and `filled` read the finer level.
template <typename ColorAt, typename FilledAt>
MipLevel reduce(int width, int height, const ColorAt& color, const FilledAt& filled) {
  MipLevel level{(width + 1) / 2, (height + 1) / 2, {}, {}};
  level.rgb.assign(static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height) * 3, 0);
  level.filled.assign(level.rgb.size() / 3, 0);
  tbb::parallel_for(tbb::blocked_range<int>(0, level.height, 16), [&](const auto& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int x = 0; x < level.width; ++x) {
        int count = 0;
        std::array<int, 3> sum{};
        for (int fy = 2 * y; fy < std::min(height, 2 * y + 2); ++fy) {
          for (int fx = 2 * x; fx < std::min(width, 2 * x + 2); ++fx) {
            if (!filled(fx, fy)) continue;
            const std::uint8_t* c = color(fx, fy);
            ++count;
            for (std::size_t k = 0; k < 3; ++k) sum[k] += c[k];
          }
        }
        if (!count) continue;
        const std::size_t i = level.at(x, y);
        level.filled[i] = 1;
        for (std::size_t k = 0; k < 3; ++k)
          level.rgb[3 * i + k] = static_cast<std::uint8_t>((sum[k] + count / 2) / count);
      }
    }
  });
  return level;
}

void copy_from_coarser(const MipLevel& coarse, int x, int y, std::uint8_t* rgb) {
  std::copy_n(coarse.rgb.data() + 3 * coarse.at(x / 2, y / 2), 3, rgb);
}

PackShape shape_of(const Chart& chart, std::span<const TexelTriangle> corners, int padding) {
  const int width = chart.width + 2 * padding, height = chart.height + 2 * padding;
  if (chart.kind == ChartKind::blocks) return box_shape(width, height);
  const CellBox box{0, 0, (width + kCell - 1) / kCell, (height + kCell - 1) / kCell};
  std::vector<std::uint8_t> bits(static_cast<std::size_t>(box.x1) * static_cast<std::size_t>(box.y1), 0);
  // A texel is in when the triangle comes within padding + 0.5 of its centre; a cell's outer centres lie
  // kCell / 2 - 0.5 from its own centre.
  const double half = (padding + kCell / 2.0) / kCell;
  for (const auto face : chart.faces) {
    TexelTriangle t = corners[face];
    for (auto& p : t) p = {(p.x + padding) / kCell, (p.y + padding) / kCell};
    triangle_spans(t, half, box, [&](int y, int first, int last) {
      const std::size_t line = static_cast<std::size_t>(y) * static_cast<std::size_t>(box.x1);
      std::fill(bits.begin() + static_cast<std::ptrdiff_t>(line + static_cast<std::size_t>(first)),
                bits.begin() + static_cast<std::ptrdiff_t>(line + static_cast<std::size_t>(last) + 1),
                std::uint8_t{1});
    });
  }
  PackShape shape{width, height, {}};
  for (int y = 0; y < box.y1; ++y) {
    const std::uint8_t* line = bits.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(box.x1);
    for (int x = 0; x < box.x1;) {
      const int first = static_cast<int>(std::find(line + x, line + box.x1, 1) - line);
      x = static_cast<int>(std::find(line + first, line + box.x1, 0) - line);
      if (first < x) shape.runs.push_back({y, first, x - first});
    }
  }
  return shape;
}

}  // namespace

Page::Page(const PageSize& size) {
  image.width = size.width, image.height = size.height;
  const std::size_t texels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  image.pixels.assign(texels * 3, 0);
  state.assign(texels, TexelState::empty);
}

std::vector<ChartPlace> chart_places(std::span<const Chart> charts, const Packing& packing, int padding) {
  std::vector<ChartPlace> places(charts.size());
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const Placement& p = packing.placements[i];
    places[i] = {p.page,
                 p.x,
                 p.y,
                 p.turns,
                 whole_cells(charts[i].width + 2 * padding),
                 whole_cells(charts[i].height + 2 * padding),
                 padding};
  }
  return places;
}

std::vector<PackShape> pack_shapes_of(const ChartSet& set, int padding) {
  std::vector<PackShape> shapes(set.charts.size());
  tbb::parallel_for(std::size_t{0}, shapes.size(),
                    [&](std::size_t i) { shapes[i] = shape_of(set.charts[i], set.corners, padding); });
  return shapes;
}

void pad_charts(Page& page, int padding) {
  const int width = page.image.width, height = page.image.height;
  std::vector<std::uint32_t> frontier;
  // A round's texels turn from empty to padding only when all of them have been computed, so none reads
  // another and the order does not matter.
  std::vector<std::uint8_t> queued(page.state.size(), 0);
  const auto for_neighbours = [&](std::uint32_t i, auto&& visit) {
    const int x = static_cast<int>(i % static_cast<std::uint32_t>(width));
    const int y = static_cast<int>(i / static_cast<std::uint32_t>(width));
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if ((dx || dy) && x + dx >= 0 && x + dx < width && y + dy >= 0 && y + dy < height)
          visit(static_cast<std::uint32_t>(page.at(x + dx, y + dy)), dx && dy);
  };
  // The first layer: ring texels, which have their colour, and empty texels beside a chart's.
  std::vector<std::vector<std::uint32_t>> rows(static_cast<std::size_t>(height));
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::uint32_t>(page.at(x, y));
      bool first_layer = page.state[i] == TexelState::ring;
      if (page.state[i] == TexelState::empty)
        for_neighbours(i, [&](std::uint32_t n, bool) { first_layer |= page.state[n] == TexelState::chart; });
      if (first_layer) rows[static_cast<std::size_t>(y)].push_back(i);
    }
  });
  for (const auto& row : rows) frontier.insert(frontier.end(), row.begin(), row.end());
  for (const auto i : frontier) queued[i] = 1;
  for (int round = 0; round < padding && !frontier.empty(); ++round) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, frontier.size(), 4096), [&](const auto& range) {
      for (std::size_t k = range.begin(); k < range.end(); ++k) {
        if (page.state[frontier[k]] == TexelState::ring) continue;
        Color sum;
        float weight = 0;
        for_neighbours(frontier[k], [&](std::uint32_t n, bool diagonal) {
          if (page.state[n] == TexelState::empty) return;
          const float w = diagonal ? 0.5f : 1.0f;
          sum = sum + w * load(page.image.pixels.data() + std::size_t{3} * n);
          weight += w;
        });
        store(page.image.pixels.data() + std::size_t{3} * frontier[k], (1 / weight) * sum);
      }
    });
    for (const auto i : frontier) page.state[i] = TexelState::padding;
    std::vector<std::uint32_t> next;
    for (const auto i : frontier) {
      for_neighbours(i, [&](std::uint32_t n, bool) {
        if (page.state[n] != TexelState::empty || queued[n]) return;
        queued[n] = 1;
        next.push_back(n);
      });
    }
    frontier = std::move(next);
  }
}

void fill_background(Page& page) {
  const int width = page.image.width, height = page.image.height;
  std::vector<MipLevel> levels;
  levels.push_back(reduce(
      width, height, [&](int x, int y) { return page.image.at(x, y); },
      [&](int x, int y) { return page.state[page.at(x, y)] != TexelState::empty; }));
  while (levels.back().width > 1 || levels.back().height > 1) {
    const MipLevel& finer = levels.back();
    levels.push_back(reduce(
        finer.width, finer.height, [&](int x, int y) { return finer.rgb.data() + 3 * finer.at(x, y); },
        [&](int x, int y) { return finer.filled[finer.at(x, y)] != 0; }));
  }
  for (std::size_t k = levels.size() - 1; k-- > 0;) {
    MipLevel& level = levels[k];
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x)
        if (const std::size_t i = level.at(x, y); !level.filled[i])
          copy_from_coarser(levels[k + 1], x, y, level.rgb.data() + 3 * i);
  }
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x)
      if (page.state[page.at(x, y)] == TexelState::empty)
        copy_from_coarser(levels[0], x, y, page.image.at(x, y));
  });
}

Color mean_color(std::span<const Page> pages) {
  std::array<std::uint64_t, 3> sum{};
  std::uint64_t count = 0;
  for (const Page& page : pages) {
    for (std::size_t i = 0; i < page.state.size(); ++i) {
      if (page.state[i] == TexelState::empty) continue;
      ++count;
      for (std::size_t k = 0; k < 3; ++k) sum[k] += page.image.pixels[3 * i + k];
    }
  }
  if (!count) return {128, 128, 128};
  const double n = static_cast<double>(count);
  return {static_cast<float>(double(sum[0]) / n), static_cast<float>(double(sum[1]) / n),
          static_cast<float>(double(sum[2]) / n)};
}

}  // namespace gpvc
