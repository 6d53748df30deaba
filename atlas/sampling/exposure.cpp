#include "atlas/sampling/exposure.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gpvc::atlas {

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

}  // namespace gpvc::atlas
