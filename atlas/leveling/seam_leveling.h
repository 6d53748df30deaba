// Making the colours of neighbouring charts meet.
//
// Three layers, each for what the one before leaves:
//   exposure  a factor per view and channel and a fall-off per camera, fitted robustly to the ratios across
//   seams
//             (least squares of logarithms, so photos are multiplied: black stays black);
//   global    an offset per vertex and view (Lempitsky and Ivanov, Seamless Mosaicing of Image-Based Texture
//             Maps, 2007): equal across seams, smooth within charts, drawn weakly towards zero;
//   strips    what still steps along a seam is spread into a strip on both sides, as Poisson blending does
//             (Perez et al. 2003), but in closed form.
#pragma once

#include "atlas/atlas.h"
#include "atlas/baking/coverage_index.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/color_correction.h"
#include "atlas/leveling/seam_samples.h"

namespace gpvc::atlas {

struct LevelingResult {
  ColorCorrection correction;
  /// Difference, in grey levels, of the means of both sides along a seam edge: absolute, averaged over channels and,
  /// weighted by length, over edges.
  double step_before = 0, step_after = 0;
};

/// SeamLeveling::none: no correction, no photo read, steps zero. Global: exposure and offsets. Deterministic.
LevelingResult level_seams(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage,
                           SeamLeveling mode);

/// Exposure per view from the ratios across seams. The geometric mean over faces of the gains is one in each channel,
/// so the texture as a whole keeps its brightness; gains lie in [1 / kMostGain, kMostGain].
std::vector<ViewExposure> fit_exposure(const AtlasInput& input, const SeamSamples& seams);

inline constexpr double kMostGain = 2.5;

/// Fills nodes and offsets; `seams` hold exposed colours.
void fit_offsets(const AtlasInput& input, const ChartSet& set, const SeamSamples& seams, ColorCorrection& correction);

}  // namespace gpvc::atlas
