// CoverageCorrection::exact, its first half: the samples of every face are found exactly and looked up, and where
// another face is stored the face contests it. Shaders do that too (shaders/scan.comp), but for faces and samples that
// they are not sure about.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <memory>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/classify/exact_owner.h"
#include "visibility/classify/face_code.h"
#include "visibility/classify/face_sampler.h"

namespace gpvc::visibility {

/// Few enough faces that they mostly lie beside each other: where sub-pixel faces are few, most rectangles around the
/// others hold no sample of them.
inline constexpr std::size_t kFacesPerRectangle = 64;

/// What is known of a view before stored owners are corrected.
struct FaceScan {
  std::vector<FaceCode> codes;  ///< per face
  /// Samples whose stored owner the face beats; before settle(), may beat. The face must cover the pixel in real
  /// arithmetic: nothing looks at that again. In any order, some twice.
  std::vector<Claim> claims;
  SampleCounts counts;  ///< of the faces that are not unsure
  /// What each kFacesPerRectangle consecutive faces may touch; empty when not known.
  std::vector<PixelBox> touched;

  /// Forgets everything but the memory.
  void start(std::size_t faces) {
    codes.resize(faces);
    claims.clear();
    counts = {};
    touched.clear();
  }
};

/// Scratch memory that views share. Results do not depend on what was scanned before, nor, but for the order of claims,
/// on threads. TBB.
class ExactScan {
 public:
  ExactScan();
  ~ExactScan();
  /// Scans all faces. O(faces + samples not stored as their own face's).
  void scan(const ClassifyView& view, FaceScan& scan);
  /// Scans the faces that shaders, or native drawing, are not sure about, and leaves of the claims those that are
  /// right.
  void settle(const ClassifyView& view, FaceScan& scan);

 private:
  class Scanner;
  Scanner& scanner();  ///< of this thread
  void start(const ClassifyView& view);
  void gather(FaceScan& scan) const;

  const ClassifyView* view_ = nullptr;  ///< at hand
  tbb::enumerable_thread_specific<std::unique_ptr<Scanner>> scanners_;
};

}  // namespace gpvc::visibility
