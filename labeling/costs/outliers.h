// Finds candidates whose photo shows another object than the face's other photos do: first face by face, then averaged
// over neighbouring faces, because an object that moves or stands in front is larger than a face.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/grouping.h"
#include "labeling/costs/face_records.h"
#include "labeling/labeling.h"

namespace gpvc::labeling {

/// Per view and channel, the logarithm to base 2 of the photo's gain: the factor by which its colours are to be divided to
/// agree with the others'. From some of the faces. O(records).
std::vector<double> photo_gains(RecordsByView& by_view, std::size_t faces);

/// Fills FaceRecord::disagreement of all records: the distance from the face's consensus colour (photo_consistency.h)
/// after removing every photo's gain, then averaged, view by view, over the neighbouring faces that the same view sees.
/// A single face whose mean colour differs, because a leaf moved or the mesh is off by a pixel, is no outlier; a face of a
/// car is. A face that touches the strip along silhouettes and is an outlier by itself (kOutlierDistance) keeps its own
/// distance, because a rim that shows what lies beyond the edge is narrow. The result does not depend on the number of
/// threads. O(records).
/// `log2_gain`: as photo_gains() gives it; views beyond its end have none.
/// `photo_of_view`: per view the photo that it shows, of whose views the first has a vote; empty: each has one.
/// `neighbours`: of all faces, see group_neighbours().
void find_outliers(RecordsByView& by_view, std::span<const double> log2_gain, const Grouped<std::uint32_t>& neighbours,
                   std::span<const std::uint32_t> photo_of_view);

}  // namespace gpvc::labeling
