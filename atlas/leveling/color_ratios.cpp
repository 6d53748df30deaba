// Colour ratios across seams and between overlapping photos, from which exposures are fitted.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "atlas/leveling/seam_leveling.h"

namespace gpvc::atlas {

namespace {

/// nullopt if no sample of the edge counts, or if a channel is too dark or too bright.
std::optional<ColorRatio> ratio_across(const AtlasInput& input, const SeamSamples& seams, const SeamEdge& edge) {
  constexpr float kMostWeight = 64;
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
  ColorRatio ratio;
  ratio.weight = double{std::min(total, kMostWeight)};
  for (std::size_t s = 0; s < 2; ++s) {
    const Color c = (1.0f / total) * sum[s];
    ratio.views[s] = static_cast<std::uint32_t>(input.labels[edge.faces[s]]);
    ratio.at[s] = {middle[s].x / double{total}, middle[s].y / double{total}};
    if (!has_logs(c)) return std::nullopt;
    ratio.logs[s] = logs_of(c);
  }
  return ratio;
}

/// What overlaps weigh beside seams. Of 0, 1, 4 and 20, 4 finds the gains of synthetic flights best (benchmarks/README.md).
constexpr double kOverlaps = 4;

/// \param counts tells which edges count
template <typename Counts>
std::vector<ColorRatio> ratios_across(const AtlasInput& input, const SeamSamples& seams, const OverlapRatios& overlaps,
                                      const Counts& counts) {
  std::vector<ColorRatio> ratios;
  double weight = 0;
  for (const SeamEdge& edge : seams.edges)
    if (counts(edge))
      if (const auto ratio = ratio_across(input, seams, edge)) weight += ratios.emplace_back(*ratio).weight;
  const std::vector<ColorRatio> beside = overlaps.ratios(weight > 0 ? kOverlaps * weight : 1);
  ratios.insert(ratios.end(), beside.begin(), beside.end());
  return ratios;
}

}  // namespace

bool has_logs(const Color& color) {
  constexpr float kDarkest = 8, kBrightest = 250;
  return std::min({color.r, color.g, color.b}) >= kDarkest && std::max({color.r, color.g, color.b}) <= kBrightest;
}

std::array<double, 3> logs_of(const Color& color) { return {std::log(color.r), std::log(color.g), std::log(color.b)}; }

std::vector<ColorRatio> color_ratios(const AtlasInput& input, const SeamSamples& seams, const OverlapRatios& overlaps) {
  return ratios_across(input, seams, overlaps, [](const SeamEdge&) { return true; });
}

std::vector<ColorRatio> color_ratios(const AtlasInput& input) {
  OverlapRatios overlaps(input);
  const SeamSamples seams =
      sample_seams(input, CoverageIndex(input.coverage), find_seams(input), {.overlaps = &overlaps});
  return ratios_across(input, seams, overlaps, [&](const SeamEdge& edge) {
    return input.border.empty() || input.border[std::min(edge.faces[0], edge.faces[1])] == 0;
  });
}

}  // namespace gpvc::atlas
