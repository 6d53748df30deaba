// From a scan of the faces to their classes (section 2.2), on the CPU.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify/exact_scan.h"
#include "visibility/classify/front_faces.h"
#include "visibility/classify/subpixel.h"

namespace gpvc::visibility {

/// What classification needs to know of a method.
struct ClassifyOptions {
  Sampling sampling = Sampling::hivers;
  CoverageCorrection correction = CoverageCorrection::exact;
  bool subpixel = true;
};

/// Scratch memory that views share. Results do not depend on what was classified before.
class CpuClassifier {
 public:
  explicit CpuClassifier(const ClassifyOptions& options) : options_(options) {}

  /// Decides what the scan leaves open, corrects stored owners, resolves sub-pixel faces and samples the faces that are
  /// not known to be full or hidden. Fills classes, coverage and the counts of the statistics. For
  /// CoverageCorrection::exact it also writes the right owners into the item buffer, which is `result.ivm` unless that is
  /// empty, and adds the time of deciding what was open to claims_s. Consumes `scan`. O(faces + pixels), TBB; the same
  /// bits for any number of threads.
  void classify(const PreparedView& view, FaceScan& scan, ViewVisibility& result);

 private:
  void find_candidates(const PreparedView& view);
  void decide_unsure(const PreparedView& view, FaceScan& scan);
  void correct_owners(const PreparedView& view, FaceScan& scan);
  void resolve_subpixel(const PreparedView& view, FaceScan& scan);
  void store_owners(const PreparedView& view, const FaceScan& scan, std::span<FaceId> ivm);
  void clear_uncovered(const PreparedView& view, const FaceScan& scan, std::span<FaceId> ivm);

  ClassifyOptions options_;
  std::vector<std::uint8_t> candidate_faces_;  ///< per face: 1 if it owns a pixel of the IVM
  ExactScanners exact_;
  tbb::enumerable_thread_specific<OwnerContest> owners_;
  OwnerOverlay overlay_;
  SubpixelResolver subpixel_;
  FaceBlocks blocks_;
};

}  // namespace gpvc::visibility
