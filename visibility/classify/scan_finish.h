// The second half of a classification, whoever scanned the faces: owners are corrected, sub-pixel faces resolved, and
// what the scan leaves open is sampled.
#pragma once

#include <vector>

#include "visibility/classify/exact_scan.h"
#include "visibility/classify/subpixel.h"

namespace gpvc::visibility {

/// Scratch memory that views share. Results do not depend on what was finished before.
class ScanFinisher {
 public:
  explicit ScanFinisher(const VisibilityOptions& options) : options_(options) {}

  /// Fills classes, coverage and the counts of the statistics; the same bits for any number of threads. No face is
  /// unsure, all claims are right. `scan` is used up. TBB; O(faces / 100 + what was left open).
  void finish(const ClassifyView& view, FaceScan& scan, ViewVisibility& result);

 private:
  void correct_owners(const ClassifyView& view, FaceScan& scan);
  void resolve_subpixel(const ClassifyView& view, FaceScan& scan);

  VisibilityOptions options_;
  OwnerOverlay overlay_;
  SubpixelResolver subpixel_;
  std::vector<BlockYield> blocks_;
};

}  // namespace gpvc::visibility
