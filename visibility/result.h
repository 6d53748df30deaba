// What a view sees of a mesh: the class of every face, the pixels of those seen in part, and the item buffer.
//
// Samples of a face in a view: the pixels of the frame whose centres lie in its projection (TLR for centres exactly on
// an edge), after clipping at z > 0. A face that reaches the frame but covers no pixel centre of it takes, when sub-pixel
// resolution is on, the centroid and the midpoints from the centroid to the three vertices; those that project outside
// the frame see nothing. A pixel is in the image when its centre, distorted, lies in the photo, on a pixel that neither
// the view's mask nor the photo's alpha excludes.
// A degenerate face, or one seen edge-on to the accuracy of doubles (thinner than about 1e-11 px), is hidden
// and hides nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "../io/scene.h"

namespace gpvc::visibility {

enum class FaceClass : std::uint8_t {
  hidden = 0,      ///< back-facing, or no in-image sample sees the face
  partial = 1,     ///< everything else
  full = 2,        ///< front-facing, all vertices in front of the camera and in [0,W] x [0,H], every sample sees it
  unresolved = 3,  ///< no pixel centre of the frame in the projection, and sub-pixel resolution is off
  background = 4,  ///< full or partial, until exclude() was told that the photo shows background there
  mixed = 5,       ///< likewise, and the photo shows a mixture of background and other things there
};

/// The item buffer of one view. Row-major from the top-left; kNoFace where nothing (or no photo) is.
struct Ivm {
  int width = 0, height = 0;
  std::vector<FaceId> faces;
  FaceId at(int x, int y) const {
    return faces[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

/// The pixels in which a partially visible face is seen: one bit per pixel of the bounding box of its in-image samples.
struct FaceCoverage {
  FaceId face{};
  ViewId view{};
  std::int32_t x0 = 0, y0 = 0;         ///< first pixel of the box
  std::int32_t width = 0, height = 0;  ///< of the box, in pixels
  std::uint32_t visible = 0;           ///< samples in which the face is seen
  float visible_share = 0;  ///< of all its samples, in (0, 1]; those outside the image, up to one frame away, count as
                            ///< hidden
  std::size_t first_word = 0;  ///< in CoverageTable::words; pixel (x, y) of the box is bit y * width + x
};

/// Faces of class partial, in face order within a view.
struct CoverageTable {
  std::vector<FaceCoverage> entries;
  std::vector<std::uint64_t> words;
  bool sees(const FaceCoverage& entry, int x, int y) const {
    const std::int64_t column = std::int64_t{x} - entry.x0, row = std::int64_t{y} - entry.y0;
    if (column < 0 || row < 0 || column >= entry.width || row >= entry.height) return false;
    const std::size_t bit = static_cast<std::size_t>(row * entry.width + column);
    return (words[entry.first_word + bit / 64] >> (bit % 64)) & 1u;
  }
};

struct VisibilityStatistics {
  std::size_t processed_faces = 0;    ///< faces classified by sampling (paper table 9)
  std::size_t samples = 0;            ///< IVM look-ups (paper: sampling count)
  std::size_t rays = 0;               ///< rays traced; samples on the same ray share it
  std::size_t corrected_samples = 0;  ///< samples whose stored owner LPCC corrected
  std::size_t contested_samples = 0;  ///< exact correction: comparisons of a sample with a stored owner
  std::size_t full = 0, partial = 0;
  double render_s = 0;    ///< drawing the IVM
  double build_s = 0;     ///< rays: building the hierarchy of the mesh; once, counted for the first view
  double upload_s = 0;    ///< to the device; the mesh once, counted for the first view
  double readback_s = 0;  ///< from the device
  double classify_s = 0;
  double shader_s = 0;  ///< part of classify_s: the compute shaders
  double claims_s = 0;  ///< part of classify_s: CPU time for what shaders or native drawing left undecided, without
                        ///< sub-pixel samples and coverage

  VisibilityStatistics& operator+=(const VisibilityStatistics& other);
};

struct ViewVisibility {
  /// Pixels outside the photo are cleared. Gpvc: the face that each pixel centre sees, in real arithmetic, whatever drew
  /// it. Other methods: as drawn.
  Ivm ivm;
  std::vector<FaceClass> classes;  ///< per face
  CoverageTable coverage;          ///< the pixels of the partial faces
  VisibilityStatistics statistics;
};

}  // namespace gpvc::visibility
