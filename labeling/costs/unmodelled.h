// Finds where photos show things that the mesh lacks: trees, wires, cars, people.
#pragma once

#include <cstdint>
#include <span>

#include "labeling/costs/cells.h"
#include "labeling/costs/face_records.h"

namespace gpvc::labeling {

/// Makes outliers of the views that show something else than the mesh's surface in a cell of faces (costs/cells.h), where
/// another view shows the surface, and inliers of those that another one clearly agrees with (FaceRecord::disagreement).
///
/// A vote of the views at each face, which find_outliers() holds, is lost where most photos show the canopy of a tree. But that
/// is in front of the surface, so each photo shows another part of it: photos that show the surface agree with each
/// other in colour and in structure, photos of a canopy do not. And where only one photo shows the surface, its colours go on
/// from where all agree, while those of the canopy begin with a step at its outline.
///
/// Each view of each cell has a probability that it shows the surface, by the mean field of a model in which it is raised by
/// - the views of the cell that agree with it, and lowered by those that differ by more than such photos do everywhere;
/// - the same view's probability in the cells beside, but across steps that it alone shows;
/// - the likeness of its colour and contrast to what photos agree on in the surroundings.
/// Where no two photos agree, as in trees that move, a face keeps one view at least, and which is refused is left to chance.
/// Constants were chosen on a synthetic city with trees, and by the error on photos held out of three real scenes.
///
/// \param cells of the records \param photo_of_view see find_outliers()
/// O(records + cells * views of a cell^2), TBB; the result does not depend on the number of threads.
void judge_cells(RecordsByView& by_view, const Cells& cells, std::span<const std::uint32_t> photo_of_view);

}  // namespace gpvc::labeling
