// Sampling one face against an IVM: dense, VES or HIVERS (algorithm 2), with the coverage of partial faces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/classify/exact_owner.h"

namespace gpvc::visibility {

struct SampleCounts {
  std::size_t processed_faces = 0;
  std::size_t samples = 0;
  std::size_t corrected_samples = 0;
  std::size_t contested_samples = 0;

  SampleCounts& operator+=(const SampleCounts& other) {
    processed_faces += other.processed_faces;
    samples += other.samples;
    corrected_samples += other.corrected_samples;
    contested_samples += other.contested_samples;
    return *this;
  }
};

/// What a block of consecutive faces yields.
struct BlockYield {
  CoverageTable coverage;
  SampleCounts counts;
  std::size_t full = 0;

  /// Keeps the memory.
  void clear();
};

/// Appends the coverage and adds the counts to the statistics.
void append(const BlockYield& block, ViewVisibility& result);

/// The coverage of all blocks, in their order; their counts are added to the statistics.
template <class Blocks>
void join(const Blocks& blocks, ViewVisibility& result) {
  result.coverage.entries.clear();
  result.coverage.words.clear();
  for (const BlockYield& block : blocks) append(block, result);
}

/// True when all vertices are in front of the camera and in [0, W] x [0, H].
bool inside_frame(const Camera& camera, const RasterFace& face);

/// The runs of pixels in the frame whose centres the face covers. Exact where `exact`, else by edge values as the
/// shaders compute them.
void collect_spans(const RasterFace& face, const SpanWalker& walker, bool exact, std::vector<Span>& spans);

class FaceSampler {
 public:
  /// `overlay`: corrected owners, for CoverageCorrection::exact. Entries and bits of partial faces are appended to
  /// `coverage`.
  FaceSampler(const ClassifyView& view, const VisibilityOptions& options, const OwnerOverlay& overlay,
              CoverageTable& coverage, SampleCounts& counts)
      : view_(view),
        options_(options),
        overlay_(overlay),
        coverage_(coverage),
        counts_(counts),
        limits_(view.quick_limits()) {}

  /// \pre a front face with a pixel centre in the frame. Full, partial or hidden.
  FaceClass classify(FaceId face);
  /// For a front face without pixel centre that `visible` of its sub-pixel samples see.
  FaceClass classify_subpixel(FaceId face, std::uint32_t visible);

 private:
  bool sees(std::int32_t x, std::int32_t y);
  bool sees_run(std::int32_t y, std::int32_t x0, std::int32_t x1);
  bool find_spans_quickly();
  bool sees_all_dense();
  bool sees_all_hivers();
  bool sees_all_ves(const SpanWalker& walker);
  bool sees_rows_between(std::size_t first, std::size_t last);
  FaceClass cover();
  std::size_t samples_around() const;
  std::size_t pixel_number(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.camera.width) + static_cast<std::size_t>(x);
  }
  bool exact() const { return options_.correction == CoverageCorrection::exact; }

  const ClassifyView& view_;
  const VisibilityOptions& options_;
  const OwnerOverlay& overlay_;
  CoverageTable& coverage_;
  SampleCounts& counts_;
  QuickLimits limits_;
  FaceId face_ = kNoFace;
  RasterFace raster_;   ///< of the face at hand, unless quick_
  bool quick_ = false;  ///< inside the frame, and its spans are certain
  std::vector<Span> spans_;
  std::size_t restored_ = 0;  ///< of the face at hand
};

}  // namespace gpvc::visibility
