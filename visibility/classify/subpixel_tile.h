// The sub-pixel samples of one tile of the image, and the faces that hide them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify/subpixel_positions.h"

namespace gpvc::visibility {

/// Samples sorted into a grid of cells over their bounding box, about three a cell: in each row of cells the samples
/// that a face may cover are consecutive.
class SubpixelTile {
 public:
  /// Numbers of samples; scratch of one thread.
  using Found = std::vector<std::uint32_t>;

  /// Removes all samples.
  void start() { samples_.clear(); }
  /// Adds a sample of `face`. The samples of one face must be added one after the other.
  void add(FaceId face, double x, double y) { samples_.push_back({x, y, face}); }
  /// Counting sort into cells; must come before the first hide_behind().
  void sort();
  /// Hides the samples of other faces that one of `faces` covers and lies in front of, decided exactly; ties go to the
  /// face that precedes_at_equal_depth(). Thread-safe.
  void hide_behind(const PreparedView& view, std::span<const FaceId> faces, Found& found);
  /// Calls sees(face, visible, all) for every face with samples here: how many are not hidden, and how many there are.
  template <class Callback>
  void for_each_face(Callback&& sees) const {
    for (std::size_t first = 0, next = 0; first < samples_.size(); first = next) {
      const FaceId face = samples_[first].face;
      std::uint32_t visible = 0;
      for (; next < samples_.size() && samples_[next].face == face; ++next) visible += visible_[next];
      sees(face, visible, static_cast<std::uint32_t>(next - first));
    }
  }

 private:
  struct Batch;
  struct Occluder;
  struct Sample {
    double x, y;
    FaceId face;
  };
  void lay_grid();
  void gather(const PreparedView& view, std::span<const FaceId> faces, Batch& batch) const;
  void hide_found(const PreparedView& view, FaceId face, std::span<const std::uint32_t> found);

  std::vector<Sample> samples_;        ///< in the order they were added
  std::vector<std::uint8_t> visible_;  ///< in the same order
  std::vector<std::uint32_t> cells_;

  double left_ = 0, top_ = 0, width_ = 0, height_ = 0;  ///< the bounding box of the samples
  std::int32_t columns_ = 1, rows_ = 1;
  float columns_per_px_ = 0, rows_per_px_ = 0;

  // Samples in the order of their cells, row by row.
  std::vector<std::uint32_t> first_;      ///< the first sample of each cell, and the end
  std::vector<float> local_x_, local_y_;  ///< relative to (left_, top_); padded for reading eight at a time
  std::vector<FaceId> by_cell_;           ///< their faces, padded as well
  std::vector<std::uint32_t> added_;      ///< their numbers in samples_
};

}  // namespace gpvc::visibility
