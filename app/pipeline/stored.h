// The members of what steps leave for other steps (io/members.h), and what a view leaves.
#pragma once

#include <cstddef>
#include <vector>

#include "../../atlas/atlas.h"
#include "../../io/image.h"
#include "../../io/members.h"
#include "../../io/scene_members.h"
#include "../../labeling/labeling.h"
#include "../../visibility/result.h"
#include "../checks/scene_fit.h"
#include "coverage_store.h"

namespace gpvc {
template <>
inline constexpr bool io::detail::kIsVector<Pixels> = true;
GPVC_MEMBERS(Image, width, height, channels, pixels)
}  // namespace gpvc

namespace gpvc::visibility {
GPVC_MEMBERS(FaceCoverage, face, view, x0, y0, width, height, visible, visible_share, first_word)
GPVC_MEMBERS(CoverageTable, entries, words)
GPVC_MEMBERS(VisibilityStatistics, processed_faces, samples, rays, corrected_samples, contested_samples, full, partial,
             render_s, build_s, upload_s, readback_s, classify_s, shader_s, claims_s)
}  // namespace gpvc::visibility

namespace gpvc::labeling {
GPVC_MEMBERS(CostTable, first, views, costs)
GPVC_MEMBERS(ViewAgreement, view, steps, correlation, chance, judged, by_chance)
GPVC_MEMBERS(PhotoJudgement, agreement, log2_gain)
GPVC_MEMBERS(SweepReport, sweep, energy, seconds)
GPVC_MEMBERS(Selection, labels, merged_patches, energy, differing_pairs, patches, sweeps)
}  // namespace gpvc::labeling

namespace gpvc::checks {
GPVC_MEMBERS(SurfaceCounts, places, found, on_mesh, off_mesh)
GPVC_MEMBERS(SmallPhoto, factor, image)
GPVC_MEMBERS(ViewFit, sees_faces, tie_points, preview)
}  // namespace gpvc::checks

namespace gpvc::pipeline {
GPVC_MEMBERS(PackedCoverage, view, bytes)

/// True if it counts tie points, and its preview is empty, or of such a photo as checks::small_photo() makes it.
inline bool is_sound(const checks::ViewFit& fit, const Camera& camera) {
  const auto& [factor, image] = fit.preview;
  const int wanted = checks::reduction(camera.width, camera.height);
  if (!checks::are_counts(fit.tie_points)) return false;
  return image.pixels.empty()
             ? image.width == 0 && image.height == 0
             : factor == wanted && image.width == camera.width / wanted && image.height == camera.height / wanted &&
                   image.channels == 1 && image.pixels.size() == pixel_index(0, image.height, image.width);
}

/// What a view sees of the faces.
struct SeenView {
  std::vector<std::byte> statistics;  ///< as labeling::CandidateCollector::statistics_of() gives them
  PackedCoverage coverage;
  visibility::VisibilityStatistics visibility;
  checks::ViewFit fit;
};
GPVC_MEMBERS(SeenView, statistics, coverage, visibility, fit)

}  // namespace gpvc::pipeline
