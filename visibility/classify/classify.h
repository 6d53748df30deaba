// Visibility classification (section 2.2) on the CPU: which faces own all, some or none of their samples.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "visibility/classify/classify_options.h"
#include "visibility/classify/face_code.h"
#include "visibility/raster/prepared_view.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {

class ExactScan;
class ScanFinisher;
struct FaceScan;

/// Scratch memory that views share. Results do not depend on what was classified before.
class CpuClassifier {
 public:
  explicit CpuClassifier(const ClassifyOptions& options);
  ~CpuClassifier();

  /// Fills classes, coverage and the counts of the statistics. O(faces + pixels), TBB; the same bits for any number of
  /// threads.
  void classify(const PreparedView& view, ViewVisibility& result);
  /// Finishes CoverageCorrection::exact when shaders or native drawing have scanned the faces. Consumes `scan`. Adds
  /// the time of deciding the faces and claims that they left open to claims_s.
  void finish_exact_scan(const PreparedView& view, FaceScan& scan, ViewVisibility& result);
  /// Finishes CoverageCorrection::off and ::paper when shaders have looked at the samples: decides unsure faces, and
  /// adds coverage and the classes of faces without pixel centre.
  void finish_codes(const PreparedView& view, std::span<const FaceCode> codes, ViewVisibility& result);

 private:
  void find_candidates(const PreparedView& view);
  void scan_faces(const PreparedView& view);
  FaceCode scan_face(const PreparedView& view, FaceId face, std::vector<Span>& spans, std::size_t& samples) const;

  ClassifyOptions options_;
  std::vector<std::uint8_t> candidate_faces_;  ///< per face: 1 if it owns a pixel of the IVM
  std::unique_ptr<FaceScan> scan_;
  std::unique_ptr<ExactScan> exact_;
  std::unique_ptr<ScanFinisher> finisher_;
};

}  // namespace gpvc::visibility
