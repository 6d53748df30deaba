// Steps at seams, continued into the charts on both sides.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "atlas/charts/charts.h"
#include "atlas/sampling/color.h"

namespace gpvc::atlas {

/// A place on a seam, in the texels of one of its charts, and the step that brings this side halfway to the other, or to a
/// finished one.
struct SeamStep {
  float x = 0, y = 0;
  float weight = 1;  ///< as in SeamSamples
  Color step;
};

/// One place on a seam, or several beside each other, as strips weigh them: offsets are means of `pull` over means of
/// `weight`.
struct StripSample {
  float x = 0, y = 0;
  float weight = 0;
  Color pull;
};
GPVC_MEMBERS(StripSample, x, y, weight, pull)

/// Seam samples of a chart, grouped by square cells of kStripCell texels, row-major.
struct ChartStrip {
  int columns = 0, rows = 0;
  Grouped<StripSample> cells;
  bool empty() const { return cells.items.empty(); }
};
GPVC_MEMBERS(ChartStrip, columns, rows, cells)

inline constexpr int kStripCell = 16;
/// Distance from the seam, in texels, at which its step has faded to zero.
inline constexpr float kStripWidth = 20;

/// True if the sample is close enough to the chart to change texels of it.
bool strip_reaches(const Chart& chart, const SeamStep& sample);

/// Groups a chart's samples by cells.
ChartStrip make_strip(const Chart& chart, std::span<const SeamStep> samples);

/// Replaces `near` by the strip's samples that have weight in a box of texels, those far from it for their closeness to
/// each other as one; by none if the box lies outside the strip, or without a strip (nullptr).
void gather_strip(const ChartStrip* strip, const CellBox& box, std::vector<StripSample>& near);

/// Texels whose strip offsets are computed together.
inline constexpr int kStripRow = 8;

/// Offsets at positions (x + i, y), 0 <= i < kStripRow: the harmonic continuation of the steps along the seam, faded
/// out over kStripWidth. For a straight seam the weights 1 / distance^2 are the Poisson kernel of the half-plane:
/// variations that are fine along the seam stay close to it, so no streaks run into the chart.
std::array<Color, kStripRow> strip_offsets(std::span<const StripSample> near, double x, double y);

/// The offset of a chart's strip, if it has one, at one position.
Color strip_offset(const ChartStrip* strip, double x, double y);

}  // namespace gpvc::atlas
