// Visibility classification (section 2.2) on the CPU: which faces own all, some or none of their samples.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "visibility/face_code.h"
#include "visibility/photo_mask.h"
#include "visibility/projection.h"
#include "visibility/quick_face.h"
#include "visibility/raster.h"
#include "visibility/visibility.h"

namespace gpvc {

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
    return ivm[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
               static_cast<std::size_t>(x)];
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
    return face_bounds(p[t[0]], p[t[1]], p[t[2]]);
  }
  QuickLimits quick_limits() const { return {camera.width, camera.height, rounding, projected.moderate}; }
  QuickFace quick(const QuickLimits& limits, FaceId face, const FaceBounds& of_face) const {
    const Triangle& t = mesh.faces[index(face)];
    const auto& p = projected.positions;
    return {limits, p[t[0]], p[t[1]], p[t[2]], of_face};
  }
  QuickDepth quick_depth(const QuickFace& quick, FaceId face) const {
    const Triangle& t = mesh.faces[index(face)];
    const auto& v = projected.vertices;
    return quick.depth(v[t[0]].z, v[t[1]].z, v[t[2]].z);
  }
  /// The least and the greatest depth of its vertices.
  DepthRange depths(FaceId face) const {
    const Triangle& t = mesh.faces[index(face)];
    const double a = projected.vertices[t[0]].z, b = projected.vertices[t[1]].z,
                 c = projected.vertices[t[2]].z;
    return {std::min(a, std::min(b, c)), std::max(a, std::max(b, c))};
  }
  PixelBox frame() const { return {0, 0, camera.width, camera.height}; }
};

class OwnerContest;
class OwnerOverlay;
class SubpixelResolver;

/// Scratch memory that views share. Results do not depend on what was classified before.
class CpuClassifier {
 public:
  explicit CpuClassifier(const VisibilityOptions& options);
  ~CpuClassifier();

  /// Fills classes, coverage and the counts of the statistics. O(faces + pixels), TBB; the same bits for any
  /// number of threads.
  void classify(const ClassifyView& view, ViewVisibility& result);
  /// The same when shaders have looked at the samples already: the codes are kept, and what they do not hold
  /// is added: coverage, and the classes of faces without pixel centre. Not for CoverageCorrection::exact.
  void complete(const ClassifyView& view, std::span<const FaceCode> codes, ViewVisibility& result);

 private:
  struct Block;
  enum class State : std::uint8_t;

  void start(const ClassifyView& view, ViewVisibility& result);
  void finish(const ClassifyView& view, ViewVisibility& result);
  void find_candidates(const ClassifyView& view);
  void scan_block(const ClassifyView& view, std::size_t number);
  State scan_face(const ClassifyView& view, FaceId face, Block& block);
  State scan_raster(const ClassifyView& view, FaceId face, const FaceBounds& bounds, Block& block);
  State scan_quick(const ClassifyView& view, FaceId face, bool front, Block& block) const;
  bool stores_everywhere(const ClassifyView& view, FaceId face, const SpanWalker& walker, Block& block) const;
  State contest(const ClassifyView& view, FaceId face, bool front, Block& block) const;
  void correct_owners(const ClassifyView& view);
  void resolve_subpixel(const ClassifyView& view);
  void finish_block(const ClassifyView& view, std::size_t number, ViewVisibility& result);

  VisibilityOptions options_;
  QuickLimits quick_;                          ///< of the view at hand
  std::vector<std::uint8_t> candidate_faces_;  ///< owns a pixel of the IVM
  std::vector<State> states_;                  ///< per face, after the scan
  std::vector<Block> blocks_;
  tbb::enumerable_thread_specific<std::unique_ptr<OwnerContest>> contests_;
  std::unique_ptr<OwnerOverlay> overlay_;
  std::unique_ptr<SubpixelResolver> subpixel_;
};

}  // namespace gpvc
