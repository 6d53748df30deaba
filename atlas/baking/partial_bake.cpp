// Texels of a partial chart: each from the best of its views, gaps closed smoothly.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "atlas/baking/baking.h"
#include "io/image.h"

namespace gpvc::atlas {

namespace {

/// The edge of a texel's footprint in the source's frame, in whole pixels; 64 at most.
int footprint_px(const TexelSource& source, int x, int y) {
  constexpr double kMost = 64;
  const auto a = source.frame_from_texel(x, y), b = source.frame_from_texel(x + 1, y),
             c = source.frame_from_texel(x, y + 1);
  if (!a || !b || !c) return 1;
  const double edge = std::max(std::hypot(b->x - a->x, b->y - a->y), std::hypot(c->x - a->x, c->y - a->y));
  // A texel as fine as the photo takes one sample, though rounding puts its edge above a pixel.
  return static_cast<int>(std::ceil(std::clamp(edge - 0.01, 1.0, kMost)));
}

/// Exposed colour of the view over a texel: one sample where texels are as fine as pixels, else the mean of the samples
/// that show the face.
std::optional<Color> sample(const AtlasBuild& build, const ViewPhoto& photo, const TexelSource& source, int x, int y) {
  const int taps = footprint_px(source, x, y);
  ColorMean mean;
  for (int j = 0; j < taps; ++j) {
    for (int i = 0; i < taps; ++i) {
      const double tx = x + (i + 0.5) / taps, ty = y + (j + 0.5) / taps;
      if (taps > 1 && sight_at(source, build.coverage.table(), tx, ty) == Sight::hidden) continue;
      const auto p = source.frame_from_texel(tx, ty);
      const auto q = p ? photo_from_pixel(photo.view.camera, *p) : std::nullopt;
      if (q) mean.add(build.correction.expose(sample_bicubic(photo.image, q->x, q->y), photo.id, *p));
    }
  }
  return mean.mean();
}

/// A level of the pyramid that smooth_fill builds.
struct Level {
  int width = 0, height = 0;
  std::vector<Color> color;
  std::vector<float> weight;
  std::size_t at(int x, int y) const {
    return pixel_index(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1), width);
  }
};

/// Means over 2 x 2 cells. A cell's weight is at most 1, which a single known texel reaches.
Level push(const Level& fine) {
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  coarse.color.resize(pixel_index(0, coarse.height, coarse.width));
  coarse.weight.resize(coarse.color.size());
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      ColorMean mean;
      for (int fy = 2 * y; fy < std::min(fine.height, 2 * y + 2); ++fy) {
        for (int fx = 2 * x; fx < std::min(fine.width, 2 * x + 2); ++fx) {
          const std::size_t i = fine.at(fx, fy);
          mean.add(fine.color[i], fine.weight[i]);
        }
      }
      coarse.color[coarse.at(x, y)] = mean.mean().value_or(Color{});
      coarse.weight[coarse.at(x, y)] = std::min(1.0f, mean.weight);
    }
  }
  return coarse;
}

/// Bilinear between the centres of the coarse level's cells.
Color interpolate(const Level& coarse, int x, int y) {
  const int nx = x / 2 + (x % 2 ? 1 : -1), ny = y / 2 + (y % 2 ? 1 : -1);
  const auto at = [&](int i, int j) { return coarse.color[coarse.at(i, j)]; };
  return 0.5625f * at(x / 2, y / 2) + 0.1875f * (at(nx, y / 2) + at(x / 2, ny)) + 0.0625f * at(nx, ny);
}

/// Push-pull (Gortler et al. 1996): fills the unknown texels of a row-major raster from the known ones, with detail
/// close to them and smoothly far away, and marks all as known. False if no texel is known. O(texels).
bool smooth_fill(std::vector<Color>& color, std::vector<std::uint8_t>& known, int width, int height) {
  if (std::find(known.begin(), known.end(), 1) == known.end()) return false;
  if (std::find(known.begin(), known.end(), 0) == known.end()) return true;
  std::vector<Level> levels(1);
  levels[0] = {width, height, std::move(color), std::vector<float>(known.begin(), known.end())};
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(push(levels.back()));
  for (std::size_t k = levels.size() - 1; k-- > 0;) {
    Level& fine = levels[k];
    for (int y = 0; y < fine.height; ++y) {
      for (int x = 0; x < fine.width; ++x) {
        const std::size_t i = fine.at(x, y);
        const float w = fine.weight[i];
        if (w < 1) fine.color[i] = w * fine.color[i] + (1 - w) * interpolate(levels[k + 1], x, y);
      }
    }
  }
  color = std::move(levels[0].color);
  std::fill(known.begin(), known.end(), std::uint8_t{1});
  return true;
}

/// An edge that faces of two charts share, in the texels of each.
struct SharedEdge {
  std::array<TexelPoint, 2> here, there;
};

TexelPoint mix(const std::array<TexelPoint, 2>& edge, double t) {
  return {edge[0].x + t * (edge[1].x - edge[0].x), edge[0].y + t * (edge[1].y - edge[0].y)};
}

std::optional<SharedEdge> shared_edge(const AtlasBuild& build, std::uint32_t face, std::size_t e, std::uint32_t other) {
  const auto &here = build.input.mesh.faces[face], &there = build.input.mesh.faces[other];
  const auto a = std::find(there.begin(), there.end(), here[e]) - there.begin();
  const auto b = std::find(there.begin(), there.end(), here[(e + 1) % 3]) - there.begin();
  if (a == 3 || b == 3) return std::nullopt;
  const TexelTriangle &from = build.set.corners[face], &to = build.set.corners[other];
  return SharedEdge{{from[e], from[(e + 1) % 3]}, {to[static_cast<std::size_t>(a)], to[static_cast<std::size_t>(b)]}};
}

/// Calls visit(place in the chart, page, place on it) along the edges that the chart shares with charts beside it, which
/// have their texels there.
template <typename Visit>
void for_border_places(const AtlasBuild& build, std::uint32_t chart, const Visit& visit) {
  const auto along = [&](const SharedEdge& edge, std::uint32_t beside) {
    const double length = std::hypot(edge.here[1].x - edge.here[0].x, edge.here[1].y - edge.here[0].y);
    const int steps = 1 + static_cast<int>(std::ceil(length));
    for (int s = 0; s <= steps; ++s) {
      const double t = double(s) / steps;
      visit(mix(edge.here, t), build.places[beside].page, build.places[beside].point(mix(edge.there, t)));
    }
  };
  for (const auto face : build.set.charts[chart].faces)
    for (const auto other : build.neighbours[face]) {
      const std::uint32_t beside = build.set.face_chart[other];
      if (beside == chart || beside >= build.set.placed) continue;
      for (std::size_t e = 0; e < 3; ++e)
        if (const auto edge = shared_edge(build, face, e, other)) along(*edge, beside);
    }
}

/// The texel at a place; nullopt where nothing is baked.
std::optional<Color> color_at(const Page& page, const TexelPoint& p) {
  const int x = std::clamp(static_cast<int>(p.x), 0, page.image.width - 1);
  const int y = std::clamp(static_cast<int>(p.y), 0, page.image.height - 1);
  if (page.state[page.at(x, y)] == TexelState::empty) return std::nullopt;
  return load(page.image.at(x, y));
}

/// Writes the texels i of a raster for which has_color(i).
template <typename HasColor>
void write(const ChartRaster& raster, std::span<const Color> color, const HasColor& has_color, std::uint32_t chart,
           AtlasBuild& build) {
  const ChartPlace& place = build.places[chart];
  Page& page = build.page_of(chart);
  for (int y = raster.box.y0; y < raster.box.y1; ++y) {
    for (int x = raster.box.x0; x < raster.box.x1; ++x) {
      const std::size_t i = raster.at(x, y);
      if (!has_color(i) || !is_baked(raster.reach[i], build.options.padding)) continue;
      const auto texel = place.texel(x, y);
      page.put(texel.x, texel.y, color[i], state_of(raster.reach[i]));
    }
  }
}

/// Fills charts in rounds. Their texels lie on their pages alone, since those of all charts together would take more
/// memory than the pages.
class PartialFiller {
 public:
  PartialFiller(std::vector<OpenChart> open, AtlasBuild& build) : open_(std::move(open)), build_(build) {}

  void fill() {
    // A chart without a known texel, whose neighbours have none either, waits until a round has filled these.
    while (!open_.empty()) {
      const std::size_t before = open_.size();
      fill_round();
      if (open_.size() == before) return fill_with_mean();
    }
  }

 private:
  /// A texel's index in the chart's raster, and its colour.
  using Seed = std::pair<std::size_t, Color>;

  /// Leaves open the charts without a known texel.
  void fill_round() {
    // All borders are read before anything is written, so that the order of charts does not matter.
    std::vector<std::vector<Seed>> seeds(open_.size());
    tbb::parallel_for(std::size_t{0}, open_.size(), [&](std::size_t k) { seeds[k] = border_seeds(open_[k]); });
    std::vector<char> filled(open_.size(), 0);
    tbb::parallel_for(std::size_t{0}, open_.size(),
                      [&](std::size_t k) { filled[k] = fill_chart(open_[k], seeds[k]) ? 1 : 0; });
    std::vector<OpenChart> left;
    for (std::size_t k = 0; k < open_.size(); ++k)
      if (!filled[k]) left.push_back(std::move(open_[k]));
    open_ = std::move(left);
  }

  /// Texels without a colour take those of the charts beside this one, along the edges that they share.
  std::vector<Seed> border_seeds(const OpenChart& chart) const {
    const CellBox box = partial_box(build_.set.charts[chart.chart]);
    std::vector<Seed> seeds;
    std::size_t kept = 0;
    for_border_places(build_, chart.chart, [&](const TexelPoint& here, std::uint32_t page, const TexelPoint& there) {
      const std::optional<Color> color =
          build_.is_early(page) ? build_.kept_beside[chart.chart].colors[kept++] : color_at(build_.pages[page], there);
      const int x = static_cast<int>(std::floor(here.x)), y = static_cast<int>(std::floor(here.y));
      if (!color || x < box.x0 || y < box.y0 || x >= box.x1 || y >= box.y1) return;
      const std::size_t i = pixel_index(x - box.x0, y - box.y0, box.x1 - box.x0);
      if (!chart.known[i]) seeds.emplace_back(i, *color);
    });
    return seeds;
  }

  /// False if the chart has neither a known texel nor a seed.
  bool fill_chart(const OpenChart& open, std::span<const Seed> seeds) {
    const Chart& chart = build_.set.charts[open.chart];
    const ChartRaster raster = rasterize(chart.faces, build_.set.corners, partial_box(chart));
    std::vector<Color> color(raster.owner.size());
    std::vector<std::uint8_t> known(open.known.begin(), open.known.end());
    const Page& page = build_.page_of(open.chart);
    for (int y = raster.box.y0; y < raster.box.y1; ++y)
      for (int x = raster.box.x0; x < raster.box.x1; ++x)
        if (const std::size_t i = raster.at(x, y); known[i] != 0) {
          const auto texel = build_.places[open.chart].texel(x, y);
          color[i] = load(page.image.at(texel.x, texel.y));
        }
    for (const auto& [i, seed] : seeds) {
      if (known[i] != 0) continue;  // the first seed of a texel counts
      color[i] = seed;
      known[i] = 1;
    }
    if (!smooth_fill(color, known, raster.width(), raster.height())) return false;
    write(
        raster, color, [](std::size_t) { return true; }, open.chart, build_);
    return true;
  }

  void fill_with_mean() {
    const Color mean = build_.mean_color();
    for (const OpenChart& open : open_) {
      const Chart& chart = build_.set.charts[open.chart];
      const ChartRaster raster = rasterize(chart.faces, build_.set.corners, partial_box(chart));
      const std::vector<Color> color(raster.owner.size(), mean);
      write(
          raster, color, [](std::size_t) { return true; }, open.chart, build_);
    }
  }

  std::vector<OpenChart> open_;
  AtlasBuild& build_;
};

}  // namespace

void take_view(PartialChart& part, const AtlasBuild& build, const ViewPhoto& photo) {
  const bool own = build.set.charts[part.chart].view == photo.id;  // the chart is this view's projection
  const auto take_texel = [&](int x, int y, const Color& strip_offset) {
    const std::size_t i = part.raster.at(x, y);
    for (const bool first : {true, false}) {
      const std::uint8_t k = first ? part.best[i] : part.second[i];
      if (k == PartialChart::kNone || part.sources_at(i)[k].view != photo.id) continue;
      auto color = sample(build, photo, part.sources_at(i)[k], x, y);
      if (!color) {
        part.best[i] = PartialChart::kNone;
        continue;
      }
      // Offsets and strips belong to the chart's own view. The colours of other views are corrected by exposure alone.
      if (own) {
        const std::uint32_t owner = part.raster.owner[i];
        *color =
            *color + build.correction.face_offset(owner, build.set.corners[owner], x + 0.5, y + 0.5) + strip_offset;
      }
      const float second_weight = static_cast<float>(part.blend[i]) / PartialChart::kBlendSteps;
      part.color[i] = part.color[i] + (first ? 1 - second_weight : second_weight) * *color;
    }
  };
  const CellBox& box = part.raster.box;
  const ChartStrip* strip = own ? build.correction.strip(part.chart) : nullptr;
  std::vector<StripSample> near;
  for (int y = box.y0; y < box.y1; y += kStripRow) {
    for (int x = box.x0; x < box.x1; x += kStripRow) {
      const CellBox block{x, y, std::min(x + kStripRow, box.x1), std::min(y + kStripRow, box.y1)};
      gather_strip(strip, block, near);
      for (int ty = block.y0; ty < block.y1; ++ty) {
        const std::array<Color, kStripRow> offsets = strip_offsets(near, x + 0.5, ty + 0.5);
        for (int tx = block.x0; tx < block.x1; ++tx) take_texel(tx, ty, offsets[static_cast<std::size_t>(tx - x)]);
      }
    }
  }
}

void want_beside_partial(AtlasBuild& build) {
  build.kept_beside.resize(build.set.placed);
  tbb::parallel_for(std::size_t{0}, build.set.placed, [&](std::size_t c) {
    const ChartKind kind = build.set.charts[c].kind;
    if (kind != ChartKind::partial && kind != ChartKind::flat) return;
    for_border_places(build, static_cast<std::uint32_t>(c),
                      [&](const TexelPoint&, std::uint32_t page, const TexelPoint& there) {
                        if (build.is_early(page)) build.kept_beside[c].want(page, there);
                      });
  });
}

void keep_beside_partial(AtlasBuild& build, std::uint32_t page) {
  tbb::parallel_for(std::size_t{0}, build.kept_beside.size(),
                    [&](std::size_t c) { build.kept_beside[c].take(page, build.pages[page], color_at); });
}

std::vector<OpenChart> write_known(std::span<const PartialChart> parts, AtlasBuild& build) {
  std::vector<OpenChart> charts(parts.size());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
    const PartialChart& part = parts[p];
    std::vector<bool>& known = charts[p].known;
    charts[p].chart = part.chart;
    known.resize(part.best.size());
    bool open = false;
    for (std::size_t i = 0; i < known.size(); ++i) {
      const bool baked = is_baked(part.raster.reach[i], build.options.padding);
      known[i] = baked && part.best[i] != PartialChart::kNone;
      open |= baked && !known[i];
    }
    write(
        part.raster, part.color, [&](std::size_t i) { return known[i]; }, part.chart, build);
    if (!open) known.clear();
  });
  std::erase_if(charts, [](const OpenChart& chart) { return chart.known.empty(); });
  return charts;
}

void fill_partial(std::vector<OpenChart> open, AtlasBuild& build) { PartialFiller(std::move(open), build).fill(); }

}  // namespace gpvc::atlas
