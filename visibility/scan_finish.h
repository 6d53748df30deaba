// CoverageCorrection::exact after a scan in shaders: the second half of what CpuClassifier does, on the faces
// and samples that shaders leave open.
#pragma once

#include <vector>

#include "visibility/exact_owner.h"
#include "visibility/face_code.h"
#include "visibility/front_faces.h"

namespace gpvc {

/// What shaders find out about a view before stored owners are corrected.
struct FaceScan {
  std::vector<FaceCode> codes;  ///< per face
  /// Samples whose stored owner the face may beat, all that it does among them; in any order, some twice.
  std::vector<Claim> claims;
  SampleCounts counts;  ///< of the faces that are not unsure
};

/// Scratch memory that views share. Results do not depend on what was finished before.
class ScanFinisher {
 public:
  explicit ScanFinisher(const VisibilityOptions& options);

  /// Fills classes, coverage and the counts of the statistics: the same bits as CpuClassifier::classify(),
  /// for any number of threads. `scan` is used up. TBB; O(faces / 100 + what was left open).
  void finish(const ClassifyView& view, FaceScan& scan, ViewVisibility& result);

 private:
  struct Part;

  void settle_open(const ClassifyView& view, FaceScan& scan);
  FaceCode scan_face(const ClassifyView& view, FaceId face, Part& part) const;
  void correct_owners(const ClassifyView& view, FaceScan& scan);
  void resolve_subpixel(const ClassifyView& view, const FaceScan& scan);
  std::uint32_t subpixel_visible(FaceId face) const;

  VisibilityOptions options_;
  OwnerOverlay overlay_;
  SubpixelResolver subpixel_;
  std::vector<FaceId> subpixel_faces_;  ///< ascending
  std::vector<PixelBox> touched_;       ///< by faces that follow one another
  FaceBlocks blocks_;
};

}  // namespace gpvc
