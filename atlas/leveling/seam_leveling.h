// Making the colours of neighbouring charts agree along their seams.
//
// Three layers, each correcting what the one before leaves:
//   exposure  a factor per view and channel and a fall-off per camera, fitted robustly to the ratios across seams
//             (least squares of logarithms, so photos are multiplied: black stays black);
//   offsets   an offset per vertex and view (Lempitsky and Ivanov, Seamless Mosaicing of Image-Based Texture
//             Maps, 2007) that makes both sides of a seam equal, varies smoothly within charts and is weakly
//             attracted to zero;
//   strips    steps that remain along a seam are spread over a strip on both sides, as in Poisson blending
//             (Perez et al. 2003), but in closed form.
#pragma once

#include "atlas/alignment/cut_places.h"
#include "atlas/atlas.h"
#include "atlas/blending/blend_weights.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/color_correction.h"
#include "atlas/leveling/overlap_ratios.h"
#include "atlas/leveling/seam_samples.h"
#include "atlas/sampling/coverage_index.h"

namespace gpvc::atlas {

struct LevelingStatistics {
  /// Absolute difference, in grey levels, of the means of both sides along a seam edge, averaged over channels and,
  /// weighted by length, over edges.
  double step_before = 0, step_after = 0;
  /// The same as CIEDE2000, between the photos as they are and with their gains and fall-off corrected alone.
  double misfit_before = 0, misfit_exposed = 0;
  CutMisfit cuts{};
};
GPVC_MEMBERS(LevelingStatistics, step_before, step_after, misfit_before, misfit_exposed, cuts)

struct LevelingResult {
  ColorCorrection correction;
  LevelingStatistics statistics;
};
GPVC_MEMBERS(LevelingResult, correction, statistics)

/// none: no correction, reads no photo, steps are zero. global: exposure and offsets. full: strips, too. Deterministic.
/// What `blending` adds to colours counts as theirs.
LevelingResult level_seams(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage,
                           const CutPlaces& cuts, const BlendWeights& blending, SeamLeveling mode);

/// Sensors quantize and clip: true where no channel is so dark that a level is several per cent, or so bright that values are unreliable.
bool has_logs(const Color& color);
/// \pre has_logs(color)
std::array<double, 3> logs_of(const Color& color);

/// The ratios across all seams, and between overlapping photos, from samples taken before.
std::vector<ColorRatio> color_ratios(const AtlasInput& input, const SeamSamples& seams, const OverlapRatios& overlaps);

/// As the public fit_exposure, from samples taken before. Gains lie in [1 / kMostGain, kMostGain].
std::vector<ViewExposure> fit_exposure(const AtlasInput& input, const SeamSamples& seams,
                                       const OverlapRatios& overlaps);

/// Fills correction.nodes and correction.offsets. \pre `seams` hold exposed colours
void fit_offsets(const AtlasInput& input, const SeamSamples& seams, ColorCorrection& correction);

}  // namespace gpvc::atlas
