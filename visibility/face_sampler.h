// Sampling one face against an IVM: dense, VES or HIVERS (algorithm 2), with the coverage of partial faces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "visibility/classify.h"

namespace gpvc {

struct SampleCounts {
  std::size_t processed_faces = 0;
  std::size_t samples = 0;
  std::size_t corrected_samples = 0;
};

class FaceSampler {
 public:
  struct Scratch {
    std::vector<Span> spans;
  };

  /// Entries and bits of partial faces are appended to `coverage`.
  FaceSampler(const ClassifyView& view, const VisibilityOptions& options, Scratch& scratch,
              CoverageTable& coverage, SampleCounts& counts)
      : view_(view), options_(options), scratch_(scratch), coverage_(coverage), counts_(counts) {}

  /// `listed`: the IVM stores the face somewhere. A face that covers a pixel centre but is not listed is
  /// hidden (lazy projection).
  FaceClass classify(FaceId face, bool listed);

 private:
  bool sees(std::int32_t x, std::int32_t y);
  bool sees_run(std::int32_t y, std::int32_t x0, std::int32_t x1);
  bool sees_all_dense();
  bool sees_all_hivers();
  bool sees_all_ves(const SpanWalker& walker);
  bool sees_rows_between(std::size_t first, std::size_t last);
  FaceClass cover();
  FaceClass classify_subpixel();
  bool covers_a_pixel() const;
  bool inside_frame() const;
  bool misses_frame() const;
  bool sees_point(const PixelPoint& q) const;
  std::size_t samples_around() const;
  template <class Callback>
  void for_each_span(const SpanWalker& walker, Callback&& callback) const;

  const ClassifyView& view_;
  const VisibilityOptions& options_;
  Scratch& scratch_;
  CoverageTable& coverage_;
  SampleCounts& counts_;
  FaceId face_ = kNoFace;
  RasterFace raster_;
  std::size_t restored_ = 0;  ///< of the face at hand
};

}  // namespace gpvc
