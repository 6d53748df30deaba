#include "atlas/blending/coarse_photo.h"

#include <algorithm>

#include "atlas/sampling/exposure.h"
#include "atlas/sampling/pixel_floats.h"
#include "io/bilinear.h"

namespace gpvc::atlas {

namespace {

FourFloats for_channels_in_place(const Color& factor) {
  return FourFloats{factor.r, factor.g, factor.b, 0} * kOutOfPlace;
}

bool has_highlights(const FourFloats& exposed) {
  return exposed[0] > kHighlight || exposed[1] > kHighlight || exposed[2] > kHighlight;
}

/// Of channels in place, so that gain times the result has the highlights that `gain` leaves.
FourFloats compressed(const FourFloats& color, const Color& gain) {
  const FourFloats exposed = color * kOutOfPlace * FourFloats{gain.r, gain.g, gain.b, 0};
  return FourFloats{with_highlights(exposed[0], gain.r) / gain.r,
                    with_highlights(exposed[1], gain.g) / gain.g / kOutOfPlace[1],
                    with_highlights(exposed[2], gain.b) / gain.b / kOutOfPlace[2], 0};
}

/// Positions as whole numbers of 2^-kFractionBits of a pixel.
constexpr int kFractionBits = 24;
constexpr std::int64_t kPixel = std::int64_t{1} << kFractionBits;

std::int64_t fixed(double pixels) {
  constexpr double kFar = 1 << 23;  // outside of all photos; as a step it leaves 64 bits after 2^16 of them
  return static_cast<std::int64_t>(std::clamp(pixels, -kFar, kFar) * double{kPixel});
}

float fraction(std::int64_t position) {
  return static_cast<float>(static_cast<std::int32_t>(position & (kPixel - 1))) * (1.0f / float{kPixel});
}

}  // namespace

CoarseRows::CoarseRows(const Image& means)
    : width_(means.width), height_(means.height), pixels_(pixel_index(0, height_ + 1, width_ + 1)) {
  std::uint32_t* to = pixels_.data();
  for (int y = 0; y <= height_; ++y) {
    const std::uint8_t* from = means.at(0, std::min(y, height_ - 1));
    for (int x = 0; x < width_; ++x, from += 3)
      *to++ = std::uint32_t{from[0]} | std::uint32_t{from[1]} << 8 | std::uint32_t{from[2]} << 16;
    *to = *(to - 1);
    ++to;
  }
}

void CoarseRows::add_row(const PhotoPoint& first, const PhotoPoint& step, const CellFactor& at,
                         const CellFactor& cell_change, std::span<ColorSum> sums) const {
  const auto columns = static_cast<std::size_t>(width_) + 1;
  const std::int64_t last_x = (width_ - 1) * kPixel, last_y = (height_ - 1) * kPixel;
  std::int64_t x = fixed(first.x / kCoarsePixel - 0.5), y = fixed(first.y / kCoarsePixel - 0.5);
  const std::int64_t step_x = fixed(step.x / kCoarsePixel), step_y = fixed(step.y / kCoarsePixel);
  const FourFloats begin = kSumUnit * for_channels_in_place(at.factor),
                   change = kSumUnit * for_channels_in_place(cell_change.factor);
  const auto gain = [&](float cell) { return at.gain + cell * cell_change.gain; };
  const Color last_gain = gain(static_cast<float>(sums.size()));
  const bool is_brightened = std::max({at.gain.r, at.gain.g, at.gain.b, last_gain.r, last_gain.g, last_gain.b}) > 1;
  float i = 0;
  for (ColorSum& sum : sums) {
    const std::int64_t u = std::clamp<std::int64_t>(x, 0, last_x), v = std::clamp<std::int64_t>(y, 0, last_y);
    const std::uint32_t* upper =
        pixels_.data() + static_cast<std::size_t>(v >> kFractionBits) * columns + (u >> kFractionBits);
    const std::uint32_t* lower = upper + columns;
    const float fx = fraction(u), fy = fraction(v);
    const FourFloats a = in_place(upper[0]), b = in_place(lower[0]);
    const FourFloats top = a + fx * (in_place(upper[1]) - a), bottom = b + fx * (in_place(lower[1]) - b);
    // Rounded; what is truncated is made positive.
    constexpr std::int32_t kShift = 1 << 15;
    FourFloats color = top + fy * (bottom - top);
    if (is_brightened && has_highlights(for_channels_in_place(gain(i)) * color)) color = compressed(color, gain(i));
    const FourInts level = __builtin_convertvector((begin + i * change) * color + (float{kShift} + 0.5f), FourInts);
    for (std::size_t c = 0; c < 3; ++c) sum[c] = static_cast<std::int16_t>(sum[c] + level[c] - kShift);
    x += step_x;
    y += step_y;
    i += 1;
  }
}

Color CoarsePhoto::at(const PhotoPoint& q) const {
  const auto rgb = bilinear<float>(*image_, q.x / kCoarsePixel, q.y / kCoarsePixel);
  return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace gpvc::atlas
