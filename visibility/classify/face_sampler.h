// Sampling one face against an item buffer for Method::gpvc: dense, VES or HIVERS (algorithm 2), with the coverage of
// partial faces.
#pragma once

#include "visibility/classify/classify.h"

namespace gpvc::visibility {

class FaceSampler {
 public:
  /// `overlay`: corrected owners, for CoverageCorrection::exact. Entries of partial faces and counts go to `block`.
  FaceSampler(const PreparedView& view, const ClassifyOptions& options, const OwnerOverlay& overlay, FaceBlock& block)
      : view_(view), options_(options), overlay_(overlay), block_(block), front_(block.front) {}

  /// \pre a front face with a pixel centre in the frame. Full, partial or hidden.
  FaceClass classify(FaceId face);
  /// For a front face without pixel centre that `visible` of its sub-pixel samples see.
  FaceClass classify_subpixel(FaceId face, std::uint32_t visible);

 private:
  bool sees(std::int32_t x, std::int32_t y);
  bool sees_all();
  template <class Test>
  bool sees_all_ves(Test& test) const;
  FaceClass cover();
  bool exact() const { return options_.correction == CoverageCorrection::exact; }

  const PreparedView& view_;
  const ClassifyOptions& options_;
  const OwnerOverlay& overlay_;
  FaceBlock& block_;
  FaceSamples& front_;
  std::size_t restored_ = 0;  ///< samples of the face whose stored owner was corrected
};

}  // namespace gpvc::visibility
