// The sub-pixel samples of one tile of the image, and the faces that hide them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify/classify.h"

namespace gpvc::visibility {

inline constexpr std::size_t kSubpixelSamples = 4;

/// Sub-pixel samples of one face: the midpoints from the centroid to the vertices, then the centroid. x is NaN for a
/// sample that is not in front of the camera.
struct SubpixelPositions {
  std::array<double, kSubpixelSamples> x, y;
};

SubpixelPositions subpixel_positions(const ClassifyView& view, FaceId face);

/// Samples in rows of cells over the rectangle around them, about three a cell: a face finds those that it may cover in
/// one run a row.
class SubpixelTile {
 public:
  /// Scratch of one thread.
  using Found = std::vector<std::uint32_t>;

  /// Forgets all samples.
  void start() { count_ = 0; }
  /// A sample of `face`. Those of one face follow one another.
  void add(FaceId face, double x, double y) {
    if (count_ == x_.size()) grow();
    x_[count_] = x;
    y_[count_] = y;
    faces_[count_] = face;
    ++count_;
  }
  /// All samples of `face`.
  void add(FaceId face, const SubpixelPositions& all) {
    if (count_ + kSubpixelSamples > x_.size()) grow();
    for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
      x_[count_ + k] = all.x[k];
      y_[count_ + k] = all.y[k];
      faces_[count_ + k] = face;
    }
    count_ += kSubpixelSamples;
  }
  /// Counting sort into cells. Before the first hide_behind().
  void sort();
  /// Hides the samples of other faces that one of `faces` covers and lies in front of, decided exactly; ties go to the
  /// lower face. Any number of threads at once.
  void hide_behind(const ClassifyView& view, const QuickLimits& limits, std::span<const FaceId> faces, Found& found);
  /// sees(face, visible, all) for every face that has samples here: how many are not hidden, and how many it has.
  template <class Callback>
  void for_each_face(Callback&& sees) const {
    for (std::size_t first = 0, next = 0; first < count_; first = next) {
      std::uint32_t visible = 0;
      for (; next < count_ && faces_[next] == faces_[first]; ++next) visible += visible_[next];
      sees(faces_[first], visible, static_cast<std::uint32_t>(next - first));
    }
  }

 private:
  struct Grid;
  struct Batch;
  struct Occluder;
  void grow();
  void lay_grid();
  void find_cells();
  void gather(const ClassifyView& view, std::span<const FaceId> faces, Batch& batch) const;
  void look_up(const ClassifyView& view, const QuickLimits& limits, FaceId face, std::size_t lane, Batch& batch) const;
  void hide_found(const ClassifyView& view, const QuickLimits& limits, FaceId face,
                  std::span<const std::uint32_t> found);

  std::size_t count_ = 0;
  std::vector<double> x_, y_;  ///< as added, like the next two
  std::vector<FaceId> faces_;
  std::vector<std::uint8_t> visible_;

  double left_ = 0, top_ = 0, width_ = 0, height_ = 0;  ///< the rectangle
  std::int32_t columns_ = 1, rows_ = 1;
  float columns_per_px_ = 0, rows_per_px_ = 0;
  std::vector<std::uint32_t> cells_;      ///< of the samples as added
  std::vector<std::uint32_t> first_;      ///< sample of a cell, row by row; one more ends the last
  std::vector<float> local_x_, local_y_;  ///< by cell, like all that follow; from the corner of the rectangle, with
                                          ///< some more for reading eight at a time
  std::vector<FaceId> by_cell_;           ///< faces
  std::vector<std::uint32_t> added_;      ///< which of the samples as added
};

}  // namespace gpvc::visibility
