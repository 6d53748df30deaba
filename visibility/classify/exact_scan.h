// The first half of CoverageCorrection::exact: finds the samples of every face exactly, looks them up in the item
// buffer, and contests those that store another face. The shaders (shaders/scan.comp) and native drawing do the same,
// except for the faces and samples that they are not sure about: settle() decides these.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <memory>
#include <vector>

#include "visibility/classify/exact_owner.h"
#include "visibility/classify/face_code.h"
#include "visibility/classify/front_faces.h"

namespace gpvc::visibility {

/// Faces per culling rectangle; small, so that rectangles stay tight: where sub-pixel faces are few, most rectangles
/// around other faces contain no sample of them.
inline constexpr std::size_t kFacesPerRectangle = 64;

/// The result of scanning a view, before stored owners are corrected.
struct FaceScan {
  std::vector<FaceCode> codes;  ///< per face
  /// Samples whose stored owner the face beats; before settle(), may beat. The face must cover the pixel in real
  /// arithmetic, which is not tested again. In any order; duplicates are allowed.
  std::vector<Claim> claims;
  SampleCounts counts;  ///< of the faces that are not unsure
  /// The pixels that each kFacesPerRectangle consecutive faces may touch; empty when not known.
  std::vector<PixelBox> touched;

  /// Clears everything and keeps the memory.
  void start(std::size_t faces) {
    codes.resize(faces);
    claims.clear();
    counts = {};
    touched.clear();
  }
};

/// Scratch memory that views share. Results do not depend on what was scanned before, nor, except for the order of
/// claims, on threads. TBB.
class ExactScan {
 public:
  ExactScan();
  ~ExactScan();
  /// Scans all faces. O(faces + samples not stored as their own face's).
  void scan(const PreparedView& view, FaceScan& scan);
  /// Scans the faces with code unsure and removes the claims that lose against the stored owner.
  void settle(const PreparedView& view, FaceScan& scan);

 private:
  class Scanner;
  tbb::enumerable_thread_specific<std::unique_ptr<Scanner>> scanners_;
};

}  // namespace gpvc::visibility
