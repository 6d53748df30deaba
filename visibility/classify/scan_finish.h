// The second half of a classification, the same for every kind of scan: corrects stored owners, resolves sub-pixel
// faces and samples the faces that the scan leaves open.
#pragma once

#include "visibility/classify/classify_options.h"
#include "visibility/classify/exact_scan.h"
#include "visibility/classify/front_faces.h"
#include "visibility/classify/subpixel.h"

namespace gpvc::visibility {

/// Scratch memory that views share. Results do not depend on what was finished before.
class ScanFinisher {
 public:
  explicit ScanFinisher(const ClassifyOptions& options) : options_(options) {}

  /// Fills classes, coverage and the counts of the statistics; the same bits for any number of threads. Consumes
  /// `scan`. \pre no face is unsure, all claims are right. TBB; O(faces + samples of the faces left open).
  void finish(const PreparedView& view, FaceScan& scan, ViewVisibility& result);

 private:
  void correct_owners(const PreparedView& view, FaceScan& scan);
  void resolve_subpixel(const PreparedView& view, FaceScan& scan);

  ClassifyOptions options_;
  OwnerOverlay overlay_;
  SubpixelResolver subpixel_;
  FaceBlocks blocks_;
};

}  // namespace gpvc::visibility
