// Visibility classification (section 2.2) on the CPU: which faces own all, some or none of their samples.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "visibility/classify/face_code.h"
#include "visibility/raster/photo_mask.h"
#include "visibility/raster/projection.h"
#include "visibility/raster/quick_face.h"
#include "visibility/raster/raster.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {

struct DepthRange {
  double nearest = 0, farthest = 0;
};

/// One view, ready to be classified. Everything is borrowed.
struct ClassifyView {
  const Mesh& mesh;
  const Camera& camera;
  ViewId id;
  const PhotoMask& mask;
  const ProjectedMesh& projected;
  std::span<const FaceId> ivm;  ///< pixels outside the photo hold kNoFace
  ProjectionRounding rounding;

  FaceId owner(std::int32_t x, std::int32_t y) const {
    return ivm[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(x)];
  }
  const FaceId* row(std::int32_t y) const {
    return ivm.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width);
  }
  RasterFace raster(FaceId face) const {
    const Triangle& t = mesh.faces[index(face)];
    const auto& v = projected.vertices;
    return raster_face(v[t[0]], v[t[1]], v[t[2]], rounding);
  }
  FaceBounds bounds(FaceId face) const {
    const Triangle& t = mesh.faces[index(face)];
    const auto& p = projected.positions;
    FaceBounds bounds = face_bounds(p[t[0]], p[t[1]], p[t[2]]);
    if (!bounds.ahead || bounds.bounded) return bounds;
    // Most of those that cross the camera plane cross it beside the frame.
    const auto& v = projected.vertices;
    bounds.ahead = !misses_frame(camera, {v[t[0]], v[t[1]], v[t[2]]});
    return bounds;
  }
  QuickLimits quick_limits() const { return {camera.width, camera.height, rounding, projected.moderate}; }
  QuickFace quick(const QuickLimits& limits, FaceId face, const FaceBounds& of_face) const {
    const Triangle& t = mesh.faces[index(face)];
    const auto& p = projected.positions;
    return {limits, p[t[0]], p[t[1]], p[t[2]], of_face};
  }
  QuickDepth quick_depth(const QuickFace& quick, FaceId face) const {
    const Triangle& t = mesh.faces[index(face)];
    const auto& p = projected.positions;
    return quick.depth(p[t[0]].per_z, p[t[1]].per_z, p[t[2]].per_z);
  }
  /// The inverse depths, rounded, of its nearest and its farthest vertex: the greatest and the least.
  DepthRange inverse_depths(FaceId face) const {
    const Triangle& t = mesh.faces[index(face)];
    const auto& p = projected.positions;
    const double a = p[t[0]].per_z, b = p[t[1]].per_z, c = p[t[2]].per_z;
    return {std::max(a, std::max(b, c)), std::min(a, std::min(b, c))};
  }
  /// The least and the greatest depth of its vertices.
  DepthRange depths(FaceId face) const {
    const Triangle& t = mesh.faces[index(face)];
    const double a = projected.vertices[t[0]].z, b = projected.vertices[t[1]].z, c = projected.vertices[t[2]].z;
    return {std::min(a, std::min(b, c)), std::max(a, std::max(b, c))};
  }
  PixelBox frame() const { return {0, 0, camera.width, camera.height}; }
};

/// Faces in blocks of a fixed size, so that what a block yields does not depend on the number of threads.
inline constexpr std::size_t kFacesPerBlock = 2048;
inline std::size_t block_count(std::size_t items) { return (items + kFacesPerBlock - 1) / kFacesPerBlock; }
/// block(number, first, end) for each block of items first .. end - 1. TBB.
template <class Callback>
void for_each_block(std::size_t items, const Callback& block) {
  tbb::parallel_for(std::size_t{0}, block_count(items), [&](std::size_t number) {
    const std::size_t first = number * kFacesPerBlock;
    block(number, first, std::min(first + kFacesPerBlock, items));
  });
}

class ExactScan;
class ScanFinisher;
struct FaceScan;

/// Scratch memory that views share. Results do not depend on what was classified before.
class CpuClassifier {
 public:
  explicit CpuClassifier(const VisibilityOptions& options);
  ~CpuClassifier();

  /// Fills classes, coverage and the counts of the statistics. O(faces + pixels), TBB; the same bits for any number of
  /// threads.
  void classify(const ClassifyView& view, ViewVisibility& result);
  /// The same, for CoverageCorrection::exact, when shaders have scanned the faces; `scan` is used up. Adds to claims_s
  /// what deciding takes that they leave open.
  void complete(const ClassifyView& view, FaceScan& scan, ViewVisibility& result);
  /// The same when shaders have looked at the samples already: the codes are kept but for unsure ones, and what they do
  /// not hold is added: coverage, and the classes of faces without pixel centre. Not for CoverageCorrection::exact.
  void complete(const ClassifyView& view, std::span<const FaceCode> codes, ViewVisibility& result);

 private:
  void find_candidates(const ClassifyView& view);
  void scan_faces(const ClassifyView& view);
  FaceCode scan_face(const ClassifyView& view, FaceId face, std::vector<Span>& spans, std::size_t& samples) const;

  VisibilityOptions options_;
  std::vector<std::uint8_t> candidate_faces_;  ///< owns a pixel of the IVM
  std::unique_ptr<FaceScan> scan_;
  std::unique_ptr<ExactScan> exact_;
  std::unique_ptr<ScanFinisher> finisher_;
};

}  // namespace gpvc::visibility
