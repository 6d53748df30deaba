// The sub-pixel samples of one tile of the image, and the faces that hide them.
#pragma once

#include <cstdint>
#include <vector>

#include "visibility/classify.h"

namespace gpvc {

/// Samples in rows of cells over the rectangle around them, about three a cell: a face finds those that it
/// may cover in one run a row.
class SubpixelTile {
 public:
  /// Forgets all samples; room for so many.
  void start(std::size_t most);
  /// A sample of `face`. `owner`: any number, for visible_by_owner().
  void add(FaceId face, std::uint32_t owner, double x, double y) {
    x_[count_] = x;
    y_[count_] = y;
    faces_[count_] = face;
    owners_[count_] = owner;
    ++count_;
  }
  /// Counting sort into cells. Before the first hide_behind().
  void sort();
  /// Hides the samples of other faces that a face covers and lies in front of, decided exactly; ties go to
  /// the lower face. `found`: scratch. Any number of threads at once.
  void hide_behind(const ClassifyView& view, const QuickLimits& limits, FaceId face,
                   std::vector<std::uint32_t>& found);
  /// sees(owner) for every sample that is not hidden.
  template <class Callback>
  void for_each_visible(Callback&& sees) const {
    for (std::size_t i = 0; i < count_; ++i)
      if (visible_[i] != 0) sees(owners_[added_[i]]);
  }

 private:
  struct Run;
  struct Occluder;
  void lay_grid();

  std::size_t count_ = 0;
  std::vector<double> x_, y_;  ///< as added, like the next two
  std::vector<FaceId> faces_;
  std::vector<std::uint32_t> owners_;

  double left_ = 0, top_ = 0, width_ = 0, height_ = 0;  ///< the rectangle
  std::int32_t columns_ = 1, rows_ = 1;
  float columns_per_px_ = 0, rows_per_px_ = 0;
  double row_height_ = 0;
  std::vector<std::uint32_t> cells_;      ///< of the samples as added
  std::vector<std::uint32_t> first_;      ///< sample of a cell, row by row; one more ends the last
  std::vector<float> local_x_, local_y_;  ///< by cell, like all that follow; from the corner of the
                                          ///< rectangle, with some more for reading eight at a time
  std::vector<FaceId> by_cell_;           ///< faces
  std::vector<std::uint32_t> added_;      ///< which of the samples as added
  std::vector<std::uint8_t> visible_;
};

}  // namespace gpvc
