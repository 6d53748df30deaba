// Colour ratios across seams, from which exposures are fitted.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "atlas/leveling/seam_leveling.h"

namespace gpvc::atlas {

namespace {

/// nullopt if no sample of the edge counts, or if a channel is too dark or too bright.
std::optional<SeamRatio> ratio_across(const AtlasInput& input, const SeamSamples& seams, const SeamEdge& edge) {
  // Sensors quantize and clip: below kDarkest a level is several per cent, and above kBrightest values are unreliable.
  constexpr float kDarkest = 8, kBrightest = 250, kMostWeight = 64;
  std::array<Color, 2> sum;
  std::array<PixelPoint, 2> middle;
  float total = 0;
  for (std::size_t i = edge.first_sample; i < edge.first_sample + edge.samples; ++i) {
    const float w = seams.weight[i];
    for (std::size_t s = 0; s < 2; ++s) {
      sum[s] = sum[s] + w * seams.colors[i][s];
      middle[s].x += double{w} * seams.frame[i][s].x;
      middle[s].y += double{w} * seams.frame[i][s].y;
    }
    total += w;
  }
  if (!(total > 0)) return std::nullopt;
  SeamRatio ratio;
  ratio.weight = double{std::min(total, kMostWeight)};
  for (std::size_t s = 0; s < 2; ++s) {
    const Color c = (1.0f / total) * sum[s];
    ratio.views[s] = static_cast<std::uint32_t>(input.labels[edge.faces[s]]);
    ratio.at[s] = {middle[s].x / double{total}, middle[s].y / double{total}};
    std::size_t k = 0;
    for (const float value : {c.r, c.g, c.b}) {
      if (!(value >= kDarkest && value <= kBrightest)) return std::nullopt;
      ratio.logs[s][k++] = std::log(value);
    }
  }
  return ratio;
}

/// \param counts tells which edges count
template <typename Counts>
std::vector<SeamRatio> ratios_across(const AtlasInput& input, const SeamSamples& seams, const Counts& counts) {
  std::vector<SeamRatio> ratios;
  for (const SeamEdge& edge : seams.edges)
    if (counts(edge))
      if (const auto ratio = ratio_across(input, seams, edge)) ratios.push_back(*ratio);
  return ratios;
}

}  // namespace

std::vector<SeamRatio> seam_ratios(const AtlasInput& input, const SeamSamples& seams) {
  return ratios_across(input, seams, [](const SeamEdge&) { return true; });
}

std::vector<SeamRatio> seam_ratios(const AtlasInput& input) {
  return ratios_across(input, sample_seams(input, CoverageIndex(input.coverage), find_seams(input)),
                       [&](const SeamEdge& edge) {
                         return input.border.empty() || input.border[std::min(edge.faces[0], edge.faces[1])] == 0;
                       });
}

}  // namespace gpvc::atlas
