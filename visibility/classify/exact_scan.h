// The first half of CoverageCorrection::exact: finds the samples of a face exactly, looks them up in the item buffer,
// and contests those that store another face. The shaders (shaders/scan.comp) and native drawing do the same, except for
// the faces and claims that they are not sure about, which decide_unsure_exactly() decides.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <span>
#include <vector>

#include "visibility/classify/exact_owner.h"
#include "visibility/classify/face_scan.h"
#include "visibility/classify/front_faces.h"

namespace gpvc::visibility {

/// The claims and counts of one thread: sets and sums, whose order does not matter.
class ExactScanner {
 public:
  void start();
  /// O(samples not stored as the face's).
  FaceCode scan(const PreparedView& view, FaceId face);
  /// Keeps those that beat the stored owner.
  void keep_right(const PreparedView& view, std::span<const Claim> claims);
  void add_to(FaceScan& scan) const;

 private:
  FaceCode contest(const PreparedView& view, FaceId face);
  void contest_run(const PreparedView& view, Contender& contender, FaceId owner, const Span& run);
  void claim_run(const PreparedView& view, Contender& contender, FaceId owner, const Span& run);

  VisibilityStatistics counts_;
  std::vector<Claim> claims_;
  FaceSamples samples_;  ///< of the current face
  OwnerContest owners_;
};

using ExactScanners = tbb::enumerable_thread_specific<ExactScanner>;

/// Scans the faces with code unsure and removes the claims that lose against the stored owner. Results do not depend on
/// what the scanners did before, nor, except for the order of claims, on threads. TBB.
void decide_unsure_exactly(const PreparedView& view, ExactScanners& scanners, FaceScan& scan);

}  // namespace gpvc::visibility
