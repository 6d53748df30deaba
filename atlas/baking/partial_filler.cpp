// The texels of partial charts that no view shows.
#include "atlas/baking/partial_filler.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <unordered_map>
#include <utility>

#include "atlas/leveling/finished_texture.h"
#include "io/freed_memory.h"
#include "io/image.h"

namespace gpvc::atlas {

namespace {

/// Push-pull (Gortler et al. 1996): fills unknown texels of a row-major raster from the known ones, with detail close to them and
/// smoothly far away. The levels of a pyramid hold means over 2 x 2 cells of the level below, where any of them is known, and
/// what is unknown lies between cells of the level above. Only what the wanted texels come to is computed.
class SmoothFill {
 public:
  /// \param known per texel \pre some are known
  SmoothFill(std::vector<std::uint8_t> known, std::vector<std::uint8_t> wanted, int width, int height) {
    levels_.push_back({width, height, std::move(known), std::move(wanted), {}});
    while (levels_.back().has_open()) levels_.push_back(above(levels_.back()));
  }

  /// Calls put(texel, colour) for those that are wanted and unknown; color(texel) gives that of a known one. O(texels x levels).
  template <typename KnownColor, typename Put>
  void fill(const KnownColor& color, const Put& put) {
    for (std::size_t k = levels_.size(); k-- > 1;) {
      levels_[k].color.resize(levels_[k].known.size());
      for_cells(levels_[k], [&](std::size_t i, int x, int y) {
        levels_[k].color[i] = levels_[k].known[i] != 0 ? mean(k, x, y, color) : interpolate(levels_[k + 1], x, y);
      });
    }
    for_cells(levels_[0], [&](std::size_t i, int x, int y) {
      if (levels_[0].known[i] == 0) put(i, interpolate(levels_[1], x, y));
    });
  }

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<std::uint8_t> known, wanted;  ///< per cell
    std::vector<Color> color;                 ///< of the wanted ones; none on the lowest level
    std::size_t at(int x, int y) const {
      return pixel_index(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1), width);
    }
    bool has_open() const {
      for (std::size_t i = 0; i < known.size(); ++i)
        if (wanted[i] != 0 && known[i] == 0) return true;
      return false;
    }
  };

  /// Calls visit(cell, x, y) for the wanted cells.
  template <typename Visit>
  static void for_cells(const Level& level, const Visit& visit) {
    std::size_t i = 0;
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x, ++i)
        if (level.wanted[i] != 0) visit(i, x, y);
  }

  /// The cell over (x, y), and those beside it that are nearest to its middle.
  struct Between {
    int x, y, next_x, next_y;
    Between(int fine_x, int fine_y)
        : x(fine_x / 2), y(fine_y / 2), next_x(x + (fine_x % 2 ? 1 : -1)), next_y(y + (fine_y % 2 ? 1 : -1)) {}
  };

  static Level above(const Level& fine) {
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}, {}};
    coarse.known.assign(pixel_index(0, coarse.height, coarse.width), 0);
    coarse.wanted.assign(coarse.known.size(), 0);
    std::size_t i = 0;
    for (int y = 0; y < fine.height; ++y) {
      const std::size_t row = coarse.at(0, y / 2);
      for (int x = 0; x < fine.width; ++x, ++i) coarse.known[row + static_cast<std::size_t>(x / 2)] |= fine.known[i];
    }
    for_cells(fine, [&](std::size_t cell, int x, int y) {
      if (fine.known[cell] != 0) return;
      const Between b(x, y);
      for (const int j : {b.y, b.next_y})
        for (const int k : {b.x, b.next_x}) coarse.wanted[coarse.at(k, j)] = 1;
    });
    return coarse;
  }

  /// Of a known cell of a level.
  template <typename KnownColor>
  Color mean(std::size_t level, int x, int y, const KnownColor& color) const {
    if (level == 0) return color(levels_[0].at(x, y));
    const Level& fine = levels_[level - 1];
    ColorMean mean_of;
    for (int fy = 2 * y; fy < std::min(fine.height, 2 * y + 2); ++fy)
      for (int fx = 2 * x; fx < std::min(fine.width, 2 * x + 2); ++fx)
        if (fine.known[fine.at(fx, fy)] != 0) mean_of.add(mean(level - 1, fx, fy, color));
    return mean_of.mean().value_or(Color{});
  }

  /// Bilinear between the centres of the coarse level's cells.
  static Color interpolate(const Level& coarse, int x, int y) {
    const Between b(x, y);
    const auto at = [&](int i, int j) { return coarse.color[coarse.at(i, j)]; };
    return 0.5625f * at(b.x, b.y) + 0.1875f * (at(b.next_x, b.y) + at(b.x, b.next_y)) +
           0.0625f * at(b.next_x, b.next_y);
  }

  std::vector<Level> levels_;
};

/// An edge that a face of a chart shares with another face: in the texels of each, and from which vertex to which.
struct SharedEdge {
  std::uint32_t other;
  std::array<TexelPoint, 2> here, there;
  std::array<std::uint32_t, 2> vertices;
};

TexelPoint mix(const std::array<TexelPoint, 2>& edge, double t) {
  return {edge[0].x + t * (edge[1].x - edge[0].x), edge[0].y + t * (edge[1].y - edge[0].y)};
}

std::optional<SharedEdge> shared_edge(const AtlasBuild& build, std::uint32_t face, std::size_t e, std::uint32_t other) {
  const auto &here = build.input.mesh.faces[face], &there = build.input.mesh.faces[other];
  const std::array vertices{here[e], here[(e + 1) % 3]};
  const auto a = std::find(there.begin(), there.end(), vertices[0]) - there.begin();
  const auto b = std::find(there.begin(), there.end(), vertices[1]) - there.begin();
  if (a == 3 || b == 3) return std::nullopt;
  const TexelTriangle &from = build.set.corners[face], &to = build.set.corners[other];
  return SharedEdge{other,
                    {from[e], from[(e + 1) % 3]},
                    {to[static_cast<std::size_t>(a)], to[static_cast<std::size_t>(b)]},
                    vertices};
}

/// Calls visit(edge, t) for places from 0 to 1, a texel apart at most, along the edges that the chart's faces share with
/// others that is_meant(other face).
template <typename IsMeant, typename Visit>
void for_edge_places(const AtlasBuild& build, std::uint32_t chart, const IsMeant& is_meant, const Visit& visit) {
  for (const auto face : build.set.charts[chart].faces)
    for (const auto other : build.neighbours[face]) {
      if (!is_meant(other)) continue;
      for (std::size_t e = 0; e < 3; ++e) {
        const auto edge = shared_edge(build, face, e, other);
        if (!edge) continue;
        const double length = std::hypot(edge->here[1].x - edge->here[0].x, edge->here[1].y - edge->here[0].y);
        const int steps = 1 + static_cast<int>(std::ceil(length));
        for (int s = 0; s <= steps; ++s) visit(*edge, double(s) / steps);
      }
    }
}

/// Calls visit(place in the chart, chart beside it, face of that chart, place on its page) along the edges that the chart shares
/// with charts beside it, which have their texels there.
template <typename Visit>
void for_border_places(const AtlasBuild& build, std::uint32_t chart, const Visit& visit) {
  const auto is_beside = [&](std::uint32_t other) {
    return build.set.face_chart[other] != chart && build.set.face_chart[other] < build.set.placed;
  };
  for_edge_places(build, chart, is_beside, [&](const SharedEdge& edge, double t) {
    const std::uint32_t beside = build.set.face_chart[edge.other];
    visit(mix(edge.here, t), beside, edge.other, build.places[beside].point(mix(edge.there, t)));
  });
}

/// Calls visit(place in the chart, colour in a layer) along the edges that the chart shares with finished faces.
template <typename Visit>
void for_finished_places(const AtlasBuild& build, std::uint32_t chart, std::size_t layer, const Visit& visit) {
  if (build.input.finished == nullptr) return;
  const auto is_meant = [&](std::uint32_t other) { return is_finished(build.input, other); };
  for_edge_places(build, chart, is_meant, [&](const SharedEdge& edge, double t) {
    visit(mix(edge.here, t), finished_color(build.input, edge.other, edge.vertices, t, layer));
  });
}

/// The index of the texel that a face of a chart shows at a place; nullopt where it shows none.
std::optional<std::size_t> texel_at(const Page& page, std::uint32_t chart, const TexelTriangle& face,
                                    const TexelPoint& p) {
  const int x = std::clamp(static_cast<int>(p.x), 0, page.image.width - 1);
  const int y = std::clamp(static_cast<int>(p.y), 0, page.image.height - 1);
  return page.shows(chart, face, x, y) ? std::optional(page.at(x, y)) : std::nullopt;
}

}  // namespace

PartialFiller::PartialFiller(AtlasBuild& build)
    : build_(build),
      unbaked_(partial_charts(build.set)),
      beside_(build.set.placed),
      waiting_(build.pages.size(), 0),
      now_(build.pages.size(), 0) {
  for (const std::uint32_t chart : unbaked_) ++waiting_[page(chart)];
}

void PartialFiller::take_baked(std::span<PartialChart> parts) {
  std::vector<OpenChart> charts;
  for (PartialChart& part : parts)
    charts.push_back({part.chart, part.is_open ? std::move(part.known) : std::vector<bool>{}});
  std::erase_if(unbaked_, [&](std::uint32_t chart) {
    return std::ranges::binary_search(parts, chart, {}, &PartialChart::chart);
  });
  note_baked(std::move(charts));
}

void PartialFiller::take_painted(std::uint32_t first_page, std::uint32_t end_page, std::vector<OpenChart> open) {
  std::ranges::sort(open, {}, &OpenChart::chart);
  std::vector<OpenChart> charts;
  auto next = open.begin();
  std::erase_if(unbaked_, [&](std::uint32_t chart) {
    if (page(chart) < first_page || page(chart) >= end_page) return false;
    if (next != open.end() && next->chart == chart)
      charts.push_back(std::move(*next++));
    else
      charts.push_back({chart, {}});
    return true;
  });
  note_baked(std::move(charts));
}

std::vector<const OpenChart*> PartialFiller::open_on(std::uint32_t page_number) const {
  std::vector<const OpenChart*> charts;
  for (const OpenChart& open : open_)
    if (page(open.chart) == page_number) charts.push_back(&open);
  std::ranges::sort(charts, {}, &OpenChart::chart);
  return charts;
}

void PartialFiller::note_baked(std::vector<OpenChart> charts) {
  for (OpenChart& chart : charts) {
    if (!chart.known.empty()) {
      open_.push_back(std::move(chart));
      continue;
    }
    beside_[chart.chart] = {};
    --waiting_[page(chart.chart)];
  }
}

void PartialFiller::look_at_borders() {
  tbb::parallel_for(std::size_t{0}, unbaked_.size(), [&](std::size_t i) { look_beside(unbaked_[i]); });
  tbb::parallel_for(std::size_t{0}, open_.size(), [&](std::size_t i) { look_beside(open_[i].chart); });
}

void PartialFiller::look_beside(std::uint32_t chart) {
  Beside& kept = beside_[chart];
  const std::size_t later = build_.painting.layers() - 1;
  std::size_t n = 0;
  for_border_places(
      build_, chart, [&](const TexelPoint&, std::uint32_t beside, std::uint32_t face, const TexelPoint& there) {
        if (n == kept.known.size()) {
          kept.known.push_back(0);
          kept.rgb.emplace_back();
          kept.samples.resize(kept.samples.size() + later);
        }
        const std::size_t place = n++;
        const Page& other = build_.pages[page(beside)];
        if (kept.known[place] != 0 || !other.is_open()) return;
        const std::optional<std::size_t> at = texel_at(other, beside, build_.on_page(beside, face), there);
        if (!at || other.state[*at] == TexelState::empty) return;
        std::copy_n(other.image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * *at), 3, kept.rgb[place].begin());
        for (std::size_t l = 0; l < later; ++l) kept.samples[place * later + l] = other.layer(l + 1).at(*at);
        kept.known[place] = 1;
      });
}

bool PartialFiller::begin_round() {
  if (open_.empty()) return false;
  std::vector<char> ready(open_.size(), 0);
  tbb::parallel_for(std::size_t{0}, open_.size(), [&](std::size_t k) {
    const std::vector<bool>& known = open_[k].known;
    const bool any = std::find(known.begin(), known.end(), true) != known.end();
    ready[k] = any || !border_seeds(open_[k], 0).empty() ? 1 : 0;
  });
  // Charts without any colour around them take the mean when no others are left.
  use_mean_ = std::find(ready.begin(), ready.end(), 1) == ready.end();
  if (use_mean_) std::fill(ready.begin(), ready.end(), char{1});
  if (use_mean_ || build_.input.layout != nullptr) mean_ = build_.mean_color();
  round_.clear();
  std::vector<OpenChart> left;
  for (std::size_t k = 0; k < open_.size(); ++k) (ready[k] != 0 ? round_ : left).push_back(std::move(open_[k]));
  open_ = std::move(left);
  for (const OpenChart& open : round_) ++now_[page(open.chart)];
  return true;
}

void PartialFiller::fill() {
  const auto is_open = [&](const OpenChart& open) { return build_.page_of(open.chart).is_open(); };
  tbb::parallel_for(std::size_t{0}, round_.size(), [&](std::size_t k) {
    if (is_open(round_[k])) fill_chart(round_[k]);
  });
  for (const OpenChart& open : round_) {
    if (!is_open(open)) continue;
    beside_[open.chart] = {};
    --now_[page(open.chart)];
    --waiting_[page(open.chart)];
  }
  std::erase_if(round_, is_open);
}

/// Texels without a colour take those of the charts beside this one, along the edges that they share.
std::vector<PartialFiller::Seed> PartialFiller::border_seeds(const OpenChart& chart, std::size_t layer) const {
  const CellBox box = partial_box(build_.set.charts[chart.chart]);
  const std::size_t later = build_.painting.layers() - 1;
  const Beside& beside = beside_[chart.chart];
  std::vector<Seed> seeds;
  const auto add = [&](const TexelPoint& here, const Color& color) {
    const int x = static_cast<int>(std::floor(here.x)), y = static_cast<int>(std::floor(here.y));
    if (x < box.x0 || y < box.y0 || x >= box.x1 || y >= box.y1) return;
    const std::size_t i = pixel_index(x - box.x0, y - box.y0, box.x1 - box.x0);
    if (!chart.known[i]) seeds.push_back({i, color});
  };
  std::size_t n = 0;
  for_border_places(build_, chart.chart, [&](const TexelPoint& here, std::uint32_t, std::uint32_t, const TexelPoint&) {
    const std::size_t place = n++;
    if (beside.known[place] != 0)
      add(here, layer == 0 ? load(beside.rgb[place].data()) : beside.samples[place * later + layer - 1]);
  });
  for_finished_places(build_, chart.chart, layer, add);
  return seeds;
}

void PartialFiller::fill_chart(const OpenChart& open) {
  const Chart& chart = build_.set.charts[open.chart];
  const ChartRaster raster = rasterize(chart.faces, build_.set.corners, partial_box(chart));
  for (std::size_t layer = 0; layer < build_.painting.layers(); ++layer) fill_chart(open, raster, layer);
}

void PartialFiller::fill_chart(const OpenChart& open, const ChartRaster& raster, std::size_t layer) {
  Page& page = build_.page_of(open.chart);
  const auto on_page = [&](std::size_t i) {
    const auto width = static_cast<std::size_t>(raster.width());
    return build_.own_texel(open.chart, raster.box.x0 + static_cast<int>(i % width),
                            raster.box.y0 + static_cast<int>(i / width));
  };
  const auto put = [&](std::size_t i, const Color& color) {
    const auto texel = on_page(i);
    if (!texel) return;
    page.put(layer, texel->x, texel->y, color);
    page.state[page.at(texel->x, texel->y)] = state_of(raster.reach[i]);
  };
  std::vector<std::uint8_t> wanted(raster.owner.size());
  for (std::size_t i = 0; i < wanted.size(); ++i)
    wanted[i] = !open.known[i] && is_baked(raster.reach[i], build_.options.padding);
  const auto put_mean = [&] {
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (wanted[i] != 0) put(i, mean_.mean(layer));
  };
  if (use_mean_) return put_mean();
  std::vector<std::uint8_t> known(open.known.begin(), open.known.end());
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i] != 0) known[i] = on_page(i).has_value();
  std::unordered_map<std::size_t, Color> seeds;
  for (const Seed& seed : border_seeds(open, layer))
    if (known[seed.texel] == 0) seeds.emplace(seed.texel, seed.color);  // the first of a texel counts
  for (const auto& [texel, color] : seeds) {
    known[texel] = 1;
    if (wanted[texel] != 0) put(texel, color);
  }
  // Of a given layout a chart may have no colour of its own, where others lie over what photos show.
  if (std::ranges::find(known, 1) == known.end()) return put_mean();
  const auto color_of = [&](std::size_t i) {
    if (const auto seed = seeds.find(i); seed != seeds.end()) return seed->second;
    const auto texel = on_page(i);
    return page.color(layer, texel->x, texel->y);
  };
  SmoothFill(std::move(known), std::move(wanted), raster.width(), raster.height()).fill(color_of, put);
}

}  // namespace gpvc::atlas
