// What is known about the faces of a view before its classes are final: by native drawing, by shaders, or nothing yet.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "visibility/method.h"
#include "visibility/raster/raster.h"
#include "visibility/result.h"

namespace gpvc::visibility {

/// Numbered as in shaders/codes.glsl. `unstored` is for CoverageCorrection::exact alone.
enum class FaceCode : std::uint8_t {
  hidden = 0,
  partial = 1,    ///< exact: some samples are stored as the face's, or all are and the face leaves the frame
  full = 2,       ///< exact: all samples are stored as the face's, and it lies in the frame
  no_centre = 3,  ///< a front face that reaches the frame but contains no pixel centre of it
  unstored = 4,   ///< a front face with samples, none of them stored as its own
  unsure = 5,     ///< left to CpuClassifier
};

/// A face that covers the centre of a pixel in real arithmetic and may be its right owner.
struct Claim {
  std::uint32_t pixel;  ///< y * width + x
  FaceId face;
};

/// Faces per culling rectangle; small, so that rectangles stay tight: where sub-pixel faces are few, most rectangles
/// around other faces contain no sample of them.
inline constexpr std::size_t kFacesPerRectangle = 64;

struct FaceScan {
  std::vector<FaceCode> codes;  ///< per face
  /// Samples of faces that are not unsure whose stored owner the face may beat. In any order; duplicates are allowed.
  std::vector<Claim> claims;
  VisibilityStatistics counts;  ///< of the faces that are not unsure
  /// Pixels of the item buffer whose stored owner may not cover their centre. Nothing: any pixel may be one.
  std::optional<std::vector<std::uint32_t>> rough_pixels;
  /// The pixels that each kFacesPerRectangle consecutive faces may touch; empty when not known.
  std::vector<PixelBox> touched;

  /// Nothing is known: all faces are unsure. Keeps the memory.
  void start(std::size_t faces) {
    codes.assign(faces, FaceCode::unsure);
    claims.clear();
    counts = {};
    rough_pixels.reset();
    touched.clear();
  }
};

}  // namespace gpvc::visibility
