// What a view's photo gives to partial charts. Texels that no view shows are filled later, see partial_filler.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

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
  const auto length2 = [&](const PixelPoint& p) { return (p.x - a->x) * (p.x - a->x) + (p.y - a->y) * (p.y - a->y); };
  const double edge = std::sqrt(std::max(length2(*b), length2(*c)));
  // A texel as fine as the photo takes one sample, though rounding puts its edge above a pixel.
  return static_cast<int>(std::ceil(std::clamp(edge - 0.01, 1.0, kMost)));
}

/// What a view shows over a texel: one sample where texels are as fine as pixels, else the mean of the samples that show the face.
struct ExposedTexel {
  Color color, gain;  ///< the former exposed
  PixelPoint frame;   ///< of the texel's middle
};
/// nullopt where nothing of it lies in the photo. \param samples become the means of the layers after the first
std::optional<ExposedTexel> sample(const AtlasBuild& build, const ViewPhoto& photo, const TexelSource& source, int x,
                                   int y, std::vector<Color>& samples) {
  const int taps = footprint_px(source, x, y);
  const Overshoot overshoot =
      build.painting.bands != nullptr && build.painting.are_limited() ? Overshoot::limited : Overshoot::kept;
  ColorMean mean, gains;
  PixelPoint frame;
  std::ranges::fill(samples, Color{});
  for (int j = 0; j < taps; ++j) {
    for (int i = 0; i < taps; ++i) {
      const double tx = x + (i + 0.5) / taps, ty = y + (j + 0.5) / taps;
      if (taps > 1 && sight_at(source, build.coverage.table(), tx, ty) == Sight::hidden) continue;
      const auto p = source.frame_from_texel(tx, ty);
      const auto q = p ? photo_from_pixel(photo.view.camera, *p) : std::nullopt;
      if (!q) continue;
      const Color gain = build.correction.gain(photo.id, *p);
      mean.add(gain * sample_bicubic(photo.image, q->x, q->y));
      gains.add(gain);
      frame = *p;
      for (std::size_t layer = 1; layer <= samples.size(); ++layer)
        samples[layer - 1] = samples[layer - 1] + sample_bicubic(photo.layer(layer), q->x, q->y, overshoot);
    }
  }
  const std::optional<Color> color = mean.mean();
  if (!color) return std::nullopt;
  for (Color& of_layer : samples) of_layer = (1 / mean.weight) * of_layer;
  return ExposedTexel{*color, *gains.mean(), frame};
}

/// Offsets of a chart's strip at texels that come in blocks of kStripRow x kStripRow, row by row.
class StripOffsets {
 public:
  /// \param strip or nullptr, for none
  StripOffsets(const ChartStrip* strip, const CellBox& box) : strip_(strip), box_(box) {}

  Color at(int x, int y) {
    if (strip_ == nullptr) return {};
    const auto start = [](int i, int first) { return first + (i - first) / kStripRow * kStripRow; };
    const int x0 = start(x, box_.x0), y0 = start(y, box_.y0);
    if (x0 != x0_ || y0 != y0_)
      gather_strip(strip_, {x0, y0, std::min(x0 + kStripRow, box_.x1), std::min(y0 + kStripRow, box_.y1)}, near_);
    if (x0 != x0_ || y != row_) offsets_ = strip_offsets(near_, x0 + 0.5, y + 0.5);
    x0_ = x0;
    y0_ = y0;
    row_ = y;
    return offsets_[static_cast<std::size_t>(x - x0)];
  }

 private:
  static constexpr int kNowhere = std::numeric_limits<int>::min();
  const ChartStrip* strip_;
  CellBox box_;
  int x0_ = kNowhere, y0_ = kNowhere;  ///< the block of near_
  int row_ = kNowhere;                 ///< the row of offsets_
  std::vector<StripSample> near_;
  std::array<Color, kStripRow> offsets_{};
};

}  // namespace

void take_view(PartialChart& part, AtlasBuild& build, const ViewPhoto& photo) {
  const Chart& chart = build.set.charts[part.chart];
  const bool own = chart.view == photo.id;  // the chart is this view's projection
  const CellBox box = partial_box(chart);
  const auto width = static_cast<std::uint32_t>(box.x1 - box.x0);
  StripOffsets strip(own ? build.correction.strip(part.chart) : nullptr, box);
  Page& page = build.page_of(part.chart);
  std::vector<Color> layers(page.layers());
  std::vector<Color> samples(page.layers() - 1);
  part.open_sums(samples.size());
  for (const TexelShares& shares : part.shares_of(photo.id)) {
    const TexelSource& source = part.sources[shares.source];
    const int y = box.y0 + static_cast<int>(shares.texel / width);
    for (std::uint32_t number = shares.texel; number < shares.texel + shares.count; ++number) {
      const int x = box.x0 + static_cast<int>(number % width);
      const auto exposed = sample(build, photo, source, x, y, samples);
      if (!exposed) {
        part.known[number] = false;
        part.is_open = true;
        continue;
      }
      // Offsets and strips belong to the chart's own view. The colours of other views are corrected by exposure alone.
      Color added;
      if (own)
        added = build.correction.face_offset(source.face, build.set.corners[source.face], x + 0.5, y + 0.5) +
                strip.at(x, y);
      layers[0] = corrected(exposed->color, added, exposed->gain);
      for (std::size_t layer = 1; layer < layers.size(); ++layer)
        layers[layer] =
            build.painting.painted(layer, samples[layer - 1], photo.id, exposed->frame, exposed->gain, added);
      if (shares.weight < PartialChart::kBlendSteps) {
        part.add_to_sums(number, static_cast<float>(shares.weight) / PartialChart::kBlendSteps, layers);
      } else {
        const auto texel = build.places[part.chart].texel(x, y);
        page.put(texel.x, texel.y, layers, state_of(shares.reach));
      }
    }
  }
}

void write_blended(const PartialChart& part, AtlasBuild& build) {
  const CellBox box = partial_box(build.set.charts[part.chart]);
  const auto width = static_cast<std::uint32_t>(box.x1 - box.x0);
  Page& page = build.page_of(part.chart);
  std::vector<Color> layers;
  for (std::size_t i = 0; i < part.blended.size(); ++i) {
    const BlendedTexel& blended = part.blended[i];
    if (!part.known[blended.texel]) continue;
    const auto texel = build.places[part.chart].texel(box.x0 + static_cast<int>(blended.texel % width),
                                                      box.y0 + static_cast<int>(blended.texel / width));
    layers.assign(1, blended.color);
    const std::span<const Color> sums = part.sums_of(i);
    layers.insert(layers.end(), sums.begin(), sums.end());
    page.put(texel.x, texel.y, layers, state_of(blended.reach));
  }
}

}  // namespace gpvc::atlas
