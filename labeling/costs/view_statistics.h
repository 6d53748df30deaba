// Statistics of every face that a view sees, from one pass over the view's IVM and its photo.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "io/image.h"
#include "io/scene.h"
#include "labeling/face_record.h"
#include "labeling/labeling.h"
#include "visibility/result.h"

namespace gpvc::labeling {

Share16 share16(double share);

/// Memory that the views share: fresh memory costs more than what is done with it.
struct ViewScratch {
  ViewScratch();
  ~ViewScratch();
  struct Block;
  struct Buffers;
  std::unique_ptr<Buffers> buffers;
};

/// Records of the full and partial faces, in face order; with `wanted`, a flag per face unless empty, of those that have
/// it. O(faces + pixels), TBB inside; sums are integers, so the result does not depend on the number of threads.
///
/// FaceRecord::quality by data term:
/// - area: projected area in pixels, times the visible share;
/// - gmi: that times the mean gradient magnitude over the face's pixels, in grey levels a pixel: the integral of the
///   gradient magnitude over the projection. Area and mean are taken apart because the pixel centres in a small face do
///   not add up to its area;
/// - area_angle, gmi_angle: area or gmi times cos^2 of the angle between the face's normal and the line of sight;
/// - nadir: see DataTerm, times the visible share.
/// A face that owns no pixel of the IVM takes gradient, colour and steps from the pixel at its centroid.
std::vector<FaceRecord> view_statistics(const Mesh& mesh, const View& view, const Image& photo,
                                        const visibility::ViewVisibility& visibility, const CostOptions& options,
                                        ViewScratch& scratch, std::span<const std::uint8_t> wanted = {});

}  // namespace gpvc::labeling
