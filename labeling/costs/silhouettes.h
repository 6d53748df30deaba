// Finds depth discontinuities of an IVM, and the strip of pixels around them, row by row.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "io/scene.h"
#include "visibility/result.h"

namespace gpvc::labeling {

/// Inverse depth of a face's plane, which is affine in the pixel: 1/z = x * (px - cx) + y * (py - cy) + constant. Floats
/// suffice: they round by 1e-7, and the relative threshold for depths is some 1e-3.
struct InverseDepth {
  float x = 0, y = 0, constant = 0;
  float at(float px, float py) const { return x * px + y * py + constant; }
};

using CameraTriangle = std::array<CameraPoint, 3>;

CameraTriangle camera_corners(const Mesh& mesh, std::size_t face, const Pose& pose);

/// Normal of a triangle, of twice the triangle's area: (b - a) x (c - a).
CameraPoint area_normal(const CameraTriangle& corners);

/// The plane of a triangle given in camera coordinates. All zero for a triangle seen edge-on, which has none.
InverseDepth inverse_depth(const Camera& camera, const CameraTriangle& corners);

/// The runs of equal faces in a row of an IVM: run i shows `faces[i]` in the pixels begins[i] .. begins[i + 1] - 1.
struct FaceRuns {
  std::vector<std::uint32_t> begins;  ///< runs + 1: the last is the row's width
  std::vector<FaceId> faces;
  std::vector<std::uint32_t> of_pixel;  ///< the run of each pixel; a few more elements are padding

  /// Keeps the memory. \pre the row is not empty
  void find(std::span<const FaceId> row);
};

/// What the strip of a view is found from. Borrows camera and IVM.
///
/// There is a discontinuity between two neighbouring pixels of different faces if the faces' planes, both evaluated at
/// both pixels, do not intersect between them and remain apart by more than `margin_px` pixel footprints (z / f). A
/// smaller step displaces the surface by less than the disagreement that the margin covers. A pixel in the photo without
/// a face (sky) makes a discontinuity, too; a pixel outside the photo does not, one that a mask excludes does.
class Silhouettes {
 public:
  /// `margin_px` >= 0: with 0 there is no strip.
  Silhouettes(const Camera& camera, const visibility::Ivm& ivm, int margin_px);

 private:
  friend class StripRows;

  /// What a pixel shows.
  struct Shown {
    FaceId face;
    const InverseDepth& plane;  ///< of the face, if there is one
    std::uint32_t x;
    int y;
  };

  std::span<const FaceId> row(int y) const;
  float centred_row(int y) const;
  bool is_step(const Shown& a, const Shown& b) const;

  const Camera& camera_;
  const visibility::Ivm& ivm_;
  int margin_px_;
  float footprints_;                    ///< the threshold of a step, relative to its depth
  std::vector<float> centred_columns_;  ///< pixel centres from cx
};

/// What the caller of StripRows knows of a face.
struct RunFace {
  InverseDepth plane;
  std::uint32_t number = 0;  ///< of the caller's choice
};

/// Walks down the rows of an IVM with their runs and the strip: the pixels within `margin_px` pixels of a depth
/// discontinuity, on both sides of it. Wherever photo and mesh disagree, the surface behind gets the colour of the one in
/// front or the other way round. Scratch memory of one thread: it holds 2 * margin_px rows at a time.
class StripRows {
 public:
  /// Fills found[i] for faces[i]; any value will do for kNoFace.
  using FindFaces = std::function<void(std::span<const FaceId> faces, std::span<RunFace> found)>;

  /// Before the first of the rows begin .. end - 1. Borrows `silhouettes`. `find_faces` is called row by row, for the
  /// faces that are not found in the row above. O(pixels of the rows and of margin_px more on
  /// either side + words of the strip * margin_px), until next() returns false.
  void start(const Silhouettes& silhouettes, int begin, int end, FindFaces find_faces);
  /// False when there are no more rows.
  bool next();

  int y() const { return y_; }
  const FaceRuns& runs() const { return row(y_).runs; }
  /// What find_faces found for each run.
  std::span<const RunFace> found() const { return row(y_).found; }
  /// A bit for each pixel of the row, 64 a word; empty without a strip.
  std::span<const std::uint64_t> strip() const { return strip_; }

 private:
  struct Row {
    FaceRuns runs;
    std::vector<RunFace> found;  ///< for the runs
    /// A bit for each pixel that touches a step; once the row below is known, for those within margin_px columns of one.
    std::vector<std::uint64_t> marks;
  };

  Row& row(int y) { return rows_[static_cast<std::size_t>(y) % rows_.size()]; }
  const Row& row(int y) const { return rows_[static_cast<std::size_t>(y) % rows_.size()]; }
  void load(int y);
  void find_faces(int y);
  void mark_steps_in_row(int y);
  void mark_steps_below(int y);
  void widen(std::vector<std::uint64_t>& marks);
  void unite();

  const Silhouettes* of_ = nullptr;
  int y_ = 0, end_ = 0;
  int first_ = 0, last_ = 0;  ///< rows that the strip of begin .. end - 1 depends on
  int loaded_ = 0;            ///< the last row known so far
  std::vector<Row> rows_;     ///< row y at y modulo the size
  std::vector<std::uint64_t> strip_, work_;
  FindFaces find_faces_;
  // Work space.
  std::vector<std::uint32_t> runs_;
  std::vector<FaceId> faces_;
  std::vector<RunFace> found_;
};

}  // namespace gpvc::labeling
