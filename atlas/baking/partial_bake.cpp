#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "atlas/baking/baking.h"
#include "atlas/baking/smooth_fill.h"

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

/// Adds what one view gives to the texels of one chart.
class ViewTaker {
 public:
  ViewTaker(PartialChart& part, const AtlasBuild& build, const ViewPhoto& photo)
      : part_(part), build_(build), photo_(photo), own_(build.set.charts[part.chart].view == photo.id) {}

  void take() {
    const CellBox& box = part_.raster.box;
    const ChartStrip* strip = own_ ? build_.correction.strip(part_.chart) : nullptr;
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

 private:
  void take_texel(int x, int y, const Color& strip_offset) {
    const std::size_t i = part_.raster.at(x, y);
    for (const bool first : {true, false}) {
      const std::uint8_t k = first ? part_.best[i] : part_.second[i];
      if (k == PartialChart::kNone || part_.sources_at(i)[k].view != photo_.id) continue;
      auto color = sample(part_.sources_at(i)[k], x, y);
      if (!color) {
        part_.best[i] = PartialChart::kNone;
        continue;
      }
      // Offsets and strips belong to the chart's own view. The colours of other views are corrected by exposure alone.
      if (own_) {
        const std::uint32_t owner = part_.raster.owner[i];
        *color =
            *color + build_.correction.face_offset(owner, build_.set.corners[owner], x + 0.5, y + 0.5) + strip_offset;
      }
      const float second_weight = static_cast<float>(part_.blend[i]) / PartialChart::kBlendSteps;
      part_.color[i] = part_.color[i] + (first ? 1 - second_weight : second_weight) * *color;
    }
  }

  /// Exposed colour of the view over a texel: one sample where texels are as fine as pixels, else the mean of the
  /// samples that show the face.
  std::optional<Color> sample(const TexelSource& source, int x, int y) const {
    const int taps = footprint_px(source, x, y);
    ColorMean mean;
    for (int j = 0; j < taps; ++j) {
      for (int i = 0; i < taps; ++i) {
        const double tx = x + (i + 0.5) / taps, ty = y + (j + 0.5) / taps;
        if (taps > 1 && sight_at(source, build_.coverage.table(), tx, ty) == Sight::hidden) continue;
        const auto p = source.frame_from_texel(tx, ty);
        const auto q = p ? photo_from_pixel(photo_.view.camera, *p) : std::nullopt;
        if (q) mean.add(build_.correction.expose(sample_bicubic(photo_.image, q->x, q->y), photo_.id, *p));
      }
    }
    return mean.mean();
  }

  PartialChart& part_;
  const AtlasBuild& build_;
  const ViewPhoto& photo_;
  bool own_;  ///< the view is the one whose projection the chart is
};

/// An edge that faces of two charts share, in the texels of each.
struct SharedEdge {
  std::array<TexelPoint, 2> here, there;
};

TexelPoint mix(const std::array<TexelPoint, 2>& edge, double t) {
  return {edge[0].x + t * (edge[1].x - edge[0].x), edge[0].y + t * (edge[1].y - edge[0].y)};
}

class PartialFinisher {
 public:
  PartialFinisher(std::span<PartialChart> parts, AtlasBuild& build) : parts_(parts), build_(build) {}

  void finish() {
    known_.resize(parts_.size());
    tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t p) {
      known_[p].resize(parts_[p].best.size());
      for (std::size_t i = 0; i < known_[p].size(); ++i) known_[p][i] = parts_[p].best[i] != PartialChart::kNone;
      write(p);
    });
    std::vector<std::size_t> open(parts_.size());
    std::iota(open.begin(), open.end(), std::size_t{0});
    // A chart without a known texel, whose neighbours have none either, waits until a round has filled these.
    while (!open.empty()) {
      std::vector<std::size_t> left = fill(open);
      if (left.size() == open.size()) return fill_with_mean(open);
      open = std::move(left);
    }
  }

 private:
  /// Returns those that have no known texel.
  std::vector<std::size_t> fill(std::span<const std::size_t> open) {
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t k) { seed_border(open[k]); });
    std::vector<char> filled(open.size(), 0);
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t k) {
      const std::size_t p = open[k];
      const ChartRaster& raster = parts_[p].raster;
      if (!smooth_fill(parts_[p].color, known_[p], raster.width(), raster.height())) return;
      write(p);
      filled[k] = 1;
    });
    std::vector<std::size_t> left;
    for (std::size_t k = 0; k < open.size(); ++k)
      if (!filled[k]) left.push_back(open[k]);
    return left;
  }

  void fill_with_mean(std::span<const std::size_t> open) {
    const Color mean = mean_color(build_.pages);
    for (const auto p : open) {
      std::fill(parts_[p].color.begin(), parts_[p].color.end(), mean);
      std::fill(known_[p].begin(), known_[p].end(), std::uint8_t{1});
      write(p);
    }
  }

  void write(std::size_t p) {
    const PartialChart& part = parts_[p];
    const ChartPlace& place = build_.places[part.chart];
    Page& page = build_.page_of(part.chart);
    const CellBox& box = part.raster.box;
    for (int y = box.y0; y < box.y1; ++y) {
      for (int x = box.x0; x < box.x1; ++x) {
        const std::size_t i = part.raster.at(x, y);
        if (!known_[p][i] || !is_baked(part.raster.reach[i], build_.options.padding)) continue;
        const auto texel = place.texel(x, y);
        page.put(texel.x, texel.y, part.color[i], state_of(part.raster.reach[i]));
      }
    }
  }

  /// Texels without a colour take those of the charts beside this one, along the edges that they share.
  void seed_border(std::size_t p) {
    const std::uint32_t chart = parts_[p].chart;
    for (const auto face : build_.set.charts[chart].faces)
      for (const auto other : build_.neighbours[face]) {
        if (build_.set.face_chart[other] == chart) continue;
        for (std::size_t e = 0; e < 3; ++e)
          if (const auto edge = shared_edge(face, e, other)) copy_across(p, *edge, build_.set.face_chart[other]);
      }
  }

  std::optional<SharedEdge> shared_edge(std::uint32_t face, std::size_t e, std::uint32_t other) const {
    const auto &here = build_.input.mesh.faces[face], &there = build_.input.mesh.faces[other];
    const auto a = std::find(there.begin(), there.end(), here[e]) - there.begin();
    const auto b = std::find(there.begin(), there.end(), here[(e + 1) % 3]) - there.begin();
    if (a == 3 || b == 3) return std::nullopt;
    const TexelTriangle &from = build_.set.corners[face], &to = build_.set.corners[other];
    return SharedEdge{{from[e], from[(e + 1) % 3]}, {to[static_cast<std::size_t>(a)], to[static_cast<std::size_t>(b)]}};
  }

  void copy_across(std::size_t p, const SharedEdge& edge, std::uint32_t chart) {
    PartialChart& part = parts_[p];
    const CellBox& box = part.raster.box;
    const Page& page = build_.page_of(chart);
    const double length = std::hypot(edge.here[1].x - edge.here[0].x, edge.here[1].y - edge.here[0].y);
    const int steps = 1 + static_cast<int>(std::ceil(length));
    for (int s = 0; s <= steps; ++s) {
      const double t = double(s) / steps;
      const TexelPoint here = mix(edge.here, t), there = build_.places[chart].point(mix(edge.there, t));
      const int x = static_cast<int>(std::floor(here.x)), y = static_cast<int>(std::floor(here.y));
      if (x < box.x0 || y < box.y0 || x >= box.x1 || y >= box.y1) continue;
      const int px = std::clamp(static_cast<int>(there.x), 0, page.image.width - 1);
      const int py = std::clamp(static_cast<int>(there.y), 0, page.image.height - 1);
      const std::size_t i = part.raster.at(x, y);
      if (known_[p][i] || page.state[page.at(px, py)] == TexelState::empty) continue;
      part.color[i] = load(page.image.at(px, py));
      known_[p][i] = 1;
    }
  }

  std::span<PartialChart> parts_;
  AtlasBuild& build_;
  std::vector<std::vector<std::uint8_t>> known_;  ///< per part and texel
};

}  // namespace

void take_view(PartialChart& part, const AtlasBuild& build, const ViewPhoto& photo) {
  ViewTaker(part, build, photo).take();
}

void finish_partial(std::span<PartialChart> parts, AtlasBuild& build) { PartialFinisher(parts, build).finish(); }

}  // namespace gpvc::atlas
