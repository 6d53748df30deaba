// What seam leveling does to a photo's colour on its way to a texel.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/baking/sampling.h"
#include "atlas/charts/charts.h"

namespace gpvc::atlas {

/// A place on a seam, in the texels of one of its charts, and what would bring this side halfway to the other.
struct StripSample {
  float x = 0, y = 0;
  float weight = 1;  ///< as in SeamSamples
  Color step;
};

/// Seam samples of a chart, by square cells of kStripCell texels.
struct ChartStrip {
  int columns = 0, rows = 0;
  std::vector<std::uint32_t> first;  ///< per cell and one more, into samples
  std::vector<StripSample> samples;
  bool empty() const { return samples.empty(); }
};

inline constexpr int kStripCell = 16;
/// Texels over which a step at a seam fades.
inline constexpr float kStripWidth = 20;

/// False where a sample lies too far from a chart to matter.
bool strip_reaches(const Chart& chart, const StripSample& sample);

/// Sorts a chart's samples into cells.
ChartStrip make_strip(const Chart& chart, std::span<const StripSample> samples);

/// The strip's samples that matter to a box of texels; none when it lies outside the strip.
void gather_strip(const ChartStrip& strip, const CellBox& box, std::vector<StripSample>& near);

/// Texels whose strip offsets are computed together.
inline constexpr int kStripRow = 8;

/// Offsets at positions (x + i, y), 0 <= i < kStripRow: the harmonic continuation of the steps along the seam, faded
/// out over kStripWidth. For a straight seam the weights 1 / distance^2 are the half-plane's Poisson kernel: what is
/// fine along the seam stays close to it, so no streaks run into the chart.
std::array<Color, kStripRow> strip_offsets(std::span<const StripSample> near, double x, double y);

/// The same at one position.
Color strip_offset(std::span<const StripSample> near, double x, double y);

/// Exposure of a view: factors a channel and a fall-off towards the corners that all views of a camera share.
struct ViewExposure {
  Color gain{1, 1, 1};
  double centre_x = 0, centre_y = 0, inverse_radius2 = 0;
  double k1 = 0, k2 = 0;  ///< log of the fall-off's inverse: k1 r^2 + k2 r^4, r = 1 at half the diagonal
  float falloff_gain(const PixelPoint& frame) const;
  Color at(const PixelPoint& frame) const { return k1 == 0 && k2 == 0 ? gain : falloff_gain(frame) * gain; }
};

struct ColorCorrection {
  std::vector<ViewExposure> exposure;               ///< per view; empty: none
  std::vector<std::array<std::uint32_t, 3>> nodes;  ///< per face and corner, into offsets; empty: none
  std::vector<Color> offsets;
  std::vector<ChartStrip> strips;  ///< per chart; empty: none

  bool identity() const { return exposure.empty() && nodes.empty() && strips.empty(); }
  Color expose(const Color& color, ViewId view, const PixelPoint& frame) const {
    return exposure.empty() ? color : exposure[index(view)].at(frame) * color;
  }
  /// Offset of a face at a position in its chart's texels; outside the face that of a place on its border.
  Color face_offset(std::uint32_t face, const TexelTriangle& corners, double x, double y) const;
  const ChartStrip* strip(std::uint32_t chart) const {
    return strips.empty() || strips[chart].empty() ? nullptr : &strips[chart];
  }
};

}  // namespace gpvc::atlas
