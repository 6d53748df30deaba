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

}  // namespace gpvc::atlas
