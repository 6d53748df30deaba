#include "atlas/leveling/seam_strips.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "atlas/leveling/seam_samples.h"
#include "io/wide_clones.h"

namespace gpvc::atlas {

namespace {

/// Distance, in texels, at which the weight of a sample has fallen smoothly to zero.
constexpr float kStripReach = kStripWidth + 8;
/// Added to squared distances, so that a texel on the seam takes the mean of a few samples.
constexpr float kSoftening = 0.5f;

/// Values of a row of texels, on which every operation is one on each of them. Compilers make no such code of the same loops.
template <std::size_t kTexels>
using Row [[gnu::vector_size(kTexels * sizeof(float))]] = float;

template <std::size_t kTexels>
[[gnu::always_inline]] inline std::array<Color, kTexels> weigh(std::span<const StripSample> near, double x, double y) {
  if (near.empty()) return {};
  using Values = Row<kTexels>;
  Values px{}, red{}, green{}, blue{}, weights{}, nearest2{};
  const Values zero{};
  for (std::size_t i = 0; i < kTexels; ++i) px[i] = static_cast<float>(x) + static_cast<float>(i);
  nearest2 += kStripWidth * kStripWidth;
  for (const StripSample& s : near) {
    const float dy = s.y - static_cast<float>(y), dy2 = dy * dy;
    const Values dx = s.x - px, d2 = dx * dx + dy2;
    nearest2 = d2 < nearest2 ? d2 : nearest2;
    const Values left = 1 - d2 * (1 / (kStripReach * kStripReach)), rest = left > zero ? left : zero;
    const Values kernel = rest * rest / (d2 + kSoftening);
    red += kernel * s.pull.r;
    green += kernel * s.pull.g;
    blue += kernel * s.pull.b;
    weights += kernel * s.weight;
  }
  std::array<Color, kTexels> result{};
  for (std::size_t i = 0; i < kTexels; ++i) {
    const float distance = std::sqrt(nearest2[i]) / kStripWidth;
    if (distance >= 1 || weights[i] <= 0) continue;
    const float fade = (1 - distance) * (1 - distance) * (1 + 2 * distance);
    result[i] = (fade / weights[i]) * Color{red[i], green[i], blue[i]};
  }
  return result;
}

/// Merges samples that follow each other in a list and are seen from a box under a small angle.
class SampleMerger {
 public:
  explicit SampleMerger(std::vector<StripSample>& merged) : merged_(merged) {}

  /// \param d2 squared distance of the sample from the box
  void add(const StripSample& s, float d2) {
    const float dx = s.x - first_.x, dy = s.y - first_.y;
    if (!(sum_.weight > 0) || dx * dx + dy * dy > least_d2_ * kSpread2) {
      close();
      first_ = s;
      least_d2_ = d2;
    }
    least_d2_ = std::min(least_d2_, d2);
    sum_.x += s.weight * s.x;
    sum_.y += s.weight * s.y;
    sum_.weight += s.weight;
    sum_.pull = sum_.pull + s.pull;
  }
  /// To be called after the last sample.
  void close() {
    if (!(sum_.weight > 0)) return;
    const float inverse = 1 / sum_.weight;
    merged_.push_back({sum_.x * inverse, sum_.y * inverse, sum_.weight, sum_.pull});
    sum_ = {};
  }

 private:
  /// Samples within d / 6 of the first are merged, d being their distance from the box. Along a seam they then spread
  /// over d / 6 and have a variance of a twelfth of its square. Half of it times the kernel's second derivative,
  /// 6 / d^4, is less than a hundredth of the kernel itself, 1 / d^2. The nearest sample seems farther by d / 288 at
  /// most, which fades a strip by less than half a hundredth of its offset.
  static constexpr float kSpread2 = 1.0f / 36;

  std::vector<StripSample>& merged_;
  StripSample first_, sum_;
  float least_d2_ = 0;
};

/// Merges those of the samples from `begin` on that lie in the same texel, where there are more than a cell has texels: where
/// thousands of slivers meet, each texel would be weighed against all of their seams.
void thin_out(std::vector<StripSample>& samples, std::size_t begin) {
  if (samples.size() - begin <= std::size_t{kStripCell} * kStripCell) return;
  const auto texel = [](const StripSample& s) { return std::pair(std::floor(s.y), std::floor(s.x)); };
  std::stable_sort(samples.begin() + static_cast<std::ptrdiff_t>(begin), samples.end(),
                   [&](const StripSample& a, const StripSample& b) { return texel(a) < texel(b); });
  std::size_t merged = begin;
  for (std::size_t i = begin; i < samples.size();) {
    StripSample sum;
    for (const auto here = texel(samples[i]); i < samples.size() && texel(samples[i]) == here; ++i) {
      sum.x += samples[i].weight * samples[i].x;
      sum.y += samples[i].weight * samples[i].y;
      sum.weight += samples[i].weight;
      sum.pull = sum.pull + samples[i].pull;
    }
    samples[merged++] = {sum.x / sum.weight, sum.y / sum.weight, sum.weight, sum.pull};
  }
  samples.resize(merged);
}

}  // namespace

bool strip_reaches(const Chart& chart, const SeamStep& s) {
  return s.x > -kStripReach && s.y > -kStripReach && s.x < static_cast<float>(chart.width) + kStripReach &&
         s.y < static_cast<float>(chart.height) + kStripReach;
}

ChartStrip make_strip(const Chart& chart, std::span<const SeamStep> samples) {
  ChartStrip strip;
  strip.columns = chart.width / kStripCell + 1;
  strip.rows = chart.height / kStripCell + 1;
  const auto cell = [&](const SeamStep& s) {
    const int x = std::clamp(static_cast<int>(s.x) / kStripCell, 0, strip.columns - 1);
    const int y = std::clamp(static_cast<int>(s.y) / kStripCell, 0, strip.rows - 1);
    return pixel_index(x, y, strip.columns);
  };
  strip.cells = group_items<StripSample>(pixel_index(0, strip.rows, strip.columns), [&](const auto& emit) {
    for (const auto& s : samples) emit(cell(s), StripSample{s.x, s.y, s.weight + kDoubt, s.weight * s.step});
  });
  Grouped<StripSample> thinned;
  thinned.items.reserve(strip.cells.items.size());
  for (std::size_t c = 0; c < strip.cells.groups(); ++c) {
    const std::size_t begin = thinned.items.size();
    const std::span<const StripSample> all = std::as_const(strip.cells)[c];
    thinned.items.insert(thinned.items.end(), all.begin(), all.end());
    thin_out(thinned.items, begin);
    thinned.first.push_back(thinned.items.size());
  }
  strip.cells = std::move(thinned);
  return strip;
}

void gather_strip(const ChartStrip* strip, const CellBox& box, std::vector<StripSample>& near) {
  near.clear();
  if (!strip) return;
  const int reach = static_cast<int>(kStripReach) + 1;
  const int x0 = std::max(0, (box.x0 - reach) / kStripCell), y0 = std::max(0, (box.y0 - reach) / kStripCell);
  const int x1 = std::min(strip->columns - 1, (box.x1 + reach) / kStripCell);
  const int y1 = std::min(strip->rows - 1, (box.y1 + reach) / kStripCell);
  if (x0 > x1) return;
  const auto left = static_cast<float>(box.x0), right = static_cast<float>(box.x1);
  const auto top = static_cast<float>(box.y0), bottom = static_cast<float>(box.y1);
  bool inside = false;
  SampleMerger merger(near);
  for (int y = y0; y <= y1; ++y) {
    // Cells beside each other have theirs one after the other.
    const std::size_t begin = strip->cells.first[pixel_index(x0, y, strip->columns)];
    const std::size_t end = strip->cells.first[pixel_index(x1, y, strip->columns) + 1];
    for (const StripSample& s : std::span(strip->cells.items).subspan(begin, end - begin)) {
      const float dx = s.x - std::clamp(s.x, left, right), dy = s.y - std::clamp(s.y, top, bottom);
      const float d2 = dx * dx + dy * dy;
      if (d2 >= kStripReach * kStripReach) continue;
      merger.add(s, d2);
      inside = inside || d2 < kStripWidth * kStripWidth;
    }
  }
  merger.close();
  if (!inside) near.clear();
}

GPVC_WIDE_CLONES std::array<Color, kStripRow> strip_offsets(std::span<const StripSample> near, double x, double y) {
  return weigh<kStripRow>(near, x, y);
}

Color strip_offset(const ChartStrip* strip, double x, double y) {
  std::vector<StripSample> near;
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  gather_strip(strip, {column, row, column + 1, row + 1}, near);
  return weigh<1>(near, x, y)[0];
}

}  // namespace gpvc::atlas
