// Candidates whose photo shows something else: judged face by face, then together with the faces around, for what moves
// or stands in front is larger than a face.
#pragma once

#include <cstddef>

#include "labeling/face_records.h"
#include "labeling/labeling.h"

namespace gpvc::labeling {

/// Fills FaceRecord::disagreement of all records: the photo-consistency of each face (photo_consistency.h) with every
/// photo's gain removed, then averaged, view by view, over the faces around that the same view sees. A single face
/// whose mean colour is off, for a leaf moved or the mesh is a pixel out, is no outlier; a face of a car is.
/// Deterministic. O(records).
void judge_records(RecordsByView& by_view, std::size_t faces, const FaceGraph& graph);

}  // namespace gpvc::labeling
