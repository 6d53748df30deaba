// How well each photo agrees with the others about what the mesh looks like: a photo at a wrong pose agrees no better
// than chance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/grouping.h"
#include "labeling/costs/face_records.h"
#include "labeling/labeling.h"

namespace gpvc::labeling {

/// Correlates the steps in brightness between faces close to each other, as each view sees them, with the mean of the
/// steps that the other views see. Steps of log brightness do not depend on exposure, and those over a few faces hardly
/// on shading, vignetting or how scenes are laid out. Chance is what the same view's steps give with the others' steps
/// elsewhere on the mesh. Uses at most a million faces, and of them those that views see whole. Deterministic, TBB.
/// O(records).
/// \param neighbours of all faces, see group_neighbours()
std::vector<ViewAgreement> measure_agreement(RecordsByView& by_view, const Grouped<std::uint32_t>& neighbours);

}  // namespace gpvc::labeling
