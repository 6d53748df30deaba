#include "atlas/leveling/color_correction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "atlas/leveling/seam_samples.h"
#include "io/wide_clones.h"

namespace gpvc::atlas {

namespace {

/// Distance, in texels, at which the weight of a sample has fallen smoothly to zero.
constexpr float kReach = kStripWidth + 8;
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
    const Values left = 1 - d2 * (1 / (kReach * kReach)), rest = left > zero ? left : zero;
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
  return s.x > -kReach && s.y > -kReach && s.x < static_cast<float>(chart.width) + kReach &&
         s.y < static_cast<float>(chart.height) + kReach;
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
  const int reach = static_cast<int>(kReach) + 1;
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
      if (d2 >= kReach * kReach) continue;
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

Color gain_at(const ViewExposure& e, const PixelPoint& frame) {
  const Color gain{e.gain[0], e.gain[1], e.gain[2]};
  if (e.k1 == 0 && e.k2 == 0) return gain;
  const double dx = frame.x - e.centre_x, dy = frame.y - e.centre_y;
  const double r2 = (dx * dx + dy * dy) * e.inverse_radius2;
  return static_cast<float>(std::exp(limited_falloff(e.k1 * r2 + e.k2 * r2 * r2))) * gain;
}

float with_highlights(float exposed, float gain) {
  constexpr float kWhite = 255, kRoom = kWhite - kHighlight;
  if (!(exposed > kHighlight) || !(gain > 1)) return exposed;
  // From a slope of 1 at kHighlight to kWhite for what is white in the photo.
  const float most = kWhite * gain - kHighlight, above = exposed - kHighlight;
  return kHighlight + above / (1 + above * (most - kRoom) / (most * kRoom));
}

Color corrected(const Color& exposed, const Color& added, const Color& gain) {
  constexpr float kDark = 8;      // grey levels, below which noise is all there is
  constexpr float kTint = 1.25f;  // of a channel, to the mean of the three
  constexpr float kAny =
      0.1f;  // changes of all channels by less leave the tint below kTint: 1.1 / ((1.1 + 0.9 + 0.9) / 3)
  constexpr auto kMost = static_cast<float>(kMostGain);
  Color color = exposed + added;
  const float largest = std::max({std::abs(added.r), std::abs(added.g), std::abs(added.b)});
  if (largest > kAny * (std::max(0.0f, std::min({exposed.r, exposed.g, exposed.b})) + kDark)) {
    const auto base = [](float channel) { return std::max(0.0f, channel) + kDark; };
    const Color from{base(exposed.r), base(exposed.g), base(exposed.b)};
    const auto ratio = [](float to, float of) { return std::max(0.0f, to + kDark) / of; };
    const Color ratios{ratio(color.r, from.r), ratio(color.g, from.g), ratio(color.b, from.b)};
    const float mean = std::clamp((ratios.r + ratios.g + ratios.b) / 3, 1 / kMost, kMost);
    const auto limited = [&](float of, float by) { return of * std::clamp(by, mean / kTint, mean * kTint) - kDark; };
    color = {limited(from.r, ratios.r), limited(from.g, ratios.g), limited(from.b, ratios.b)};
  }
  return {with_highlights(color.r, gain.r), with_highlights(color.g, gain.g), with_highlights(color.b, gain.b)};
}

LocalGain::LocalGain(const ViewExposure& exposure, const PixelPoint& middle)
    : exposure_(exposure), middle_(falloff(middle)), gain_(gain_at(exposure, middle)) {}

OffsetPlane::OffsetPlane(const TexelTriangle& t, const std::array<Color, 3>& offsets) : corner_(t[0]) {
  const double ux = t[1].x - t[0].x, uy = t[1].y - t[0].y, vx = t[2].x - t[0].x, vy = t[2].y - t[0].y;
  const double area = ux * vy - uy * vx, inverse = area == 0 ? 0 : 1 / area;
  std::size_t k = 0;
  for (const auto channel : {&Color::r, &Color::g, &Color::b}) {
    const float a = offsets[0].*channel, b = offsets[1].*channel, c = offsets[2].*channel;
    const double to_b = double{b} - double{a}, to_c = double{c} - double{a};
    channels_[k++] = {double{a}, (to_b * vy - to_c * uy) * inverse, (to_c * ux - to_b * vx) * inverse,
                      std::min({a, b, c}), std::max({a, b, c})};
  }
}

namespace {

/// At a position in a face's texels, of what its corners have.
Color between(const std::array<Color, 3>& at, const TexelTriangle& t, double x, double y) {
  if (doubled_area(t) == 0) return (1.0f / 3) * (at[0] + at[1] + at[2]);
  const std::array<double, 3> share = shares_at(t, x, y);
  return static_cast<float>(share[0]) * at[0] + static_cast<float>(share[1]) * at[1] +
         static_cast<float>(share[2]) * at[2];
}

}  // namespace

Color ColorCorrection::face_offset(std::uint32_t face, const TexelTriangle& t, double x, double y) const {
  if (nodes.empty()) return {};
  return between({offsets[nodes[face][0]], offsets[nodes[face][1]], offsets[nodes[face][2]]}, t, x, y);
}

bool ColorCorrection::limits_strip(std::uint32_t face) const {
  return !strip_shares.empty() && std::ranges::any_of(nodes[face], [&](std::uint32_t node) {
    const Color& share = strip_shares[node];
    return share.r < 1 || share.g < 1 || share.b < 1;
  });
}

Color ColorCorrection::taken(const Color& strip, std::uint32_t face, const TexelTriangle& t, double x, double y) const {
  if (!limits_strip(face)) return strip;
  return between({strip_shares[nodes[face][0]], strip_shares[nodes[face][1]], strip_shares[nodes[face][2]]}, t, x, y) *
         strip;
}

namespace {

bool is_finite(const Color& color) {
  return std::isfinite(color.r) && std::isfinite(color.g) && std::isfinite(color.b);
}

// The cells of make_strip().
bool is_sound(const ChartStrip& strip, const Chart& chart) {
  if (strip.empty()) return true;
  const std::vector<std::size_t>& first = strip.cells.first;
  return strip.columns == chart.width / kStripCell + 1 && strip.rows == chart.height / kStripCell + 1 &&
         first.size() == pixel_index(0, strip.rows, strip.columns) + 1 && std::ranges::is_sorted(first) &&
         first.back() <= strip.cells.items.size() && std::ranges::all_of(strip.cells.items, [](const StripSample& s) {
           return std::isfinite(s.x) && std::isfinite(s.y) && std::isfinite(s.weight) && s.weight > 0 &&
                  is_finite(s.pull);
         });
}

}  // namespace

bool is_sound(const ColorCorrection& correction, const AtlasInput& input, const ChartSet& set) {
  const auto is_node = [&](std::uint32_t node) { return node < correction.offsets.size(); };
  for (std::size_t c = 0; c < correction.strips.size(); ++c)
    if (c >= set.charts.size() || !is_sound(correction.strips[c], set.charts[c])) return false;
  const auto fits = [](const auto& list, std::size_t size) { return list.empty() || list.size() == size; };
  return fits(correction.exposure, input.scene.views.size()) && fits(correction.nodes, input.mesh.faces.size()) &&
         fits(correction.strips, set.charts.size()) && fits(correction.strip_shares, correction.offsets.size()) &&
         std::ranges::all_of(correction.strip_shares, is_finite) &&
         std::ranges::all_of(correction.offsets, is_finite) &&
         std::ranges::all_of(correction.exposure, [](const ViewExposure& each) { return is_sound(each); }) &&
         std::ranges::all_of(correction.nodes,
                             [&](const auto& of_face) { return std::ranges::all_of(of_face, is_node); });
}

}  // namespace gpvc::atlas
