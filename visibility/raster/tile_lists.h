// A frame cut into square tiles, and lists of the faces that may touch each tile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "visibility/raster/prepared_view.h"

namespace gpvc::visibility {

/// Upper bound of how far rounding puts a sub-pixel sample or a rounded position of a vertex beside its face, in pixels. A
/// sample is a weighted mean of the vertices: with r = 2^-53 it is off by less than 16 r times the mean of their
/// coordinates' sizes. Where that reaches 2^26 px for a sample on the frame, the face reaches as far on either side of it
/// and touches the whole frame anyway.
inline constexpr double kSampleSlack = 0x1p-24;

class TileGrid {
 public:
  TileGrid() = default;
  /// Tiles of 2^`shift` pixels a side, row by row.
  TileGrid(const PixelBox& frame, int shift)
      : frame_(frame), shift_(shift), across_(line_of(frame.x1 - 1) + 1), down_(line_of(frame.y1 - 1) + 1) {}
  std::size_t count() const { return static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_); }
  /// The pixels of a tile that lie on the frame.
  PixelBox pixels(std::size_t tile) const {
    const std::int32_t x = static_cast<std::int32_t>(tile) % across_ << shift_;
    const std::int32_t y = static_cast<std::int32_t>(tile) / across_ << shift_;
    const std::int32_t side = 1 << shift_;
    return {x, y, std::min(x + side, frame_.x1), std::min(y + side, frame_.y1)};
  }
  /// The tile of a pixel.
  std::size_t tile_of(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(line_of(y)) * static_cast<std::size_t>(across_) +
           static_cast<std::size_t>(line_of(x));
  }
  /// The tile of a position on the frame; one on its right or lower border belongs to the last tile.
  std::size_t tile_of(double x, double y) const {
    return tile_of(std::min(static_cast<std::int32_t>(x), frame_.x1 - 1),
                   std::min(static_cast<std::int32_t>(y), frame_.y1 - 1));
  }
  /// How many tiles the box touches.
  std::int64_t touched(const PixelBox& box) const {
    if (box.empty()) return 0;
    return std::int64_t{line_of(box.x1 - 1) - line_of(box.x0) + 1} * (line_of(box.y1 - 1) - line_of(box.y0) + 1);
  }
  /// Calls tile(number) for each tile that the box touches. Tiles that the face and its sub-pixel samples certainly do
  /// not touch are left out where `face` knows: a sliver across many tiles fills little of its bounding box.
  template <class Callback>
  void for_each(const PixelBox& box, const QuickFace& face, const Callback& tile) const {
    if (box.empty()) return;
    RowCrossings edges;
    const bool known = face.cross(box, edges);
    const std::int32_t last_row = line_of(box.y1 - 1);
    for (std::int32_t row = line_of(box.y0); row <= last_row; ++row) {
      PixelBox part = box;
      if (known) {
        // Rows and columns count from the centres of the box's first pixel, half a pixel from the tile's borders.
        const double top = (row << shift_) - box.y0 - 0.5 - kSampleSlack, first_x = box.x0 + 0.5;
        const RowRange range = range_of_rows(edges, top, top + (1 << shift_) + 2 * kSampleSlack);
        const double slack = edges.tolerance + kSampleSlack;
        part = touched_pixels({first_x + range.low - slack, 0, first_x + range.high + slack, 0, true, true}, box);
      }
      for (std::int32_t column = line_of(part.x0); part.x0 < part.x1 && column <= line_of(part.x1 - 1); ++column)
        tile(static_cast<std::size_t>(row * across_ + column));
    }
  }
  /// True when test(number) is for one of the tiles that the box touches.
  template <class Test>
  bool any_of(const PixelBox& box, const Test& test) const {
    if (box.empty()) return false;
    for (std::int32_t row = line_of(box.y0); row <= line_of(box.y1 - 1); ++row)
      for (std::int32_t column = line_of(box.x0); column <= line_of(box.x1 - 1); ++column)
        if (test(static_cast<std::size_t>(row * across_ + column))) return true;
    return false;
  }

 private:
  /// The column or row of tiles of a pixel's column or row.
  std::int32_t line_of(std::int32_t pixel) const { return pixel >> shift_; }

  PixelBox frame_;
  int shift_ = 0;
  std::int32_t across_ = 0, down_ = 0;
};

/// Prefetches the vertices of a face a few places ahead of `at` in a list, and the corner indices of one twice as far
/// ahead, which the former needs by then.
inline void prefetch(const PreparedView& view, std::span<const FaceId> faces, std::size_t at) {
  constexpr std::size_t kAhead = 8;
  if (at + 2 * kAhead >= faces.size()) return;
  __builtin_prefetch(&view.mesh.faces[index(faces[at + 2 * kAhead])]);
  for (const std::uint32_t vertex : view.mesh.faces[index(faces[at + kAhead])]) {
    __builtin_prefetch(&view.projected.positions[vertex]);
    __builtin_prefetch(&view.projected.vertices[vertex]);
  }
}

/// Lists are made in this many parts, whatever the number of threads: enough to occupy every thread.
inline constexpr std::size_t kListParts = 64;

/// Faces by tile. Parts list faces concurrently; then a counting sort joins them. Within a tile faces come part by
/// part, in the order they were added.
class TileLists {
 public:
  class Part {
   public:
    void add(std::size_t tile, FaceId face) {
      found_.push_back({static_cast<std::uint32_t>(tile), face});
      ++count_[tile];
    }

   private:
    friend class TileLists;
    struct Entry {
      std::uint32_t tile;
      FaceId face;
    };
    std::vector<Entry> found_;
    std::vector<std::uint32_t> count_;  ///< per tile; while sorting, where the next entry goes
  };

  /// Clears the lists and keeps their memory.
  void start(std::size_t parts, std::size_t tiles);
  /// Each part must be used by one thread at a time.
  Part& part(std::size_t number) { return parts_[number]; }
  /// After all parts have listed. O(entries + parts x tiles). TBB.
  void sort();
  std::span<const FaceId> of(std::size_t tile) const {
    return std::span(faces_).subspan(first_[tile], first_[tile + 1] - first_[tile]);
  }

 private:
  std::vector<Part> parts_;
  std::vector<std::size_t> first_;  ///< of each tile in faces_, and the end
  std::vector<FaceId> faces_;
};

}  // namespace gpvc::visibility
