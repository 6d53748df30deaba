// An image in square tiles, and lists of the faces that may touch each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify/classify.h"

namespace gpvc::visibility {

class TileGrid {
 public:
  TileGrid() = default;
  /// Tiles of 2^`shift` pixels a side.
  TileGrid(const PixelBox& frame, int shift)
      : frame_(frame), shift_(shift), across_(tile_of(frame.x1 - 1) + 1), down_(tile_of(frame.y1 - 1) + 1) {}
  std::int32_t across() const { return across_; }
  std::int32_t down() const { return down_; }
  std::size_t count() const { return static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_); }
  /// Of the frame.
  PixelBox pixels(std::size_t tile) const {
    const std::int32_t x = static_cast<std::int32_t>(tile) % across_ << shift_;
    const std::int32_t y = static_cast<std::int32_t>(tile) / across_ << shift_;
    const std::int32_t side = 1 << shift_;
    return {x, y, std::min(x + side, frame_.x1), std::min(y + side, frame_.y1)};
  }
  /// How many tiles the box touches.
  std::int64_t touched(const PixelBox& box) const {
    if (box.empty()) return 0;
    return std::int64_t{tile_of(box.x1 - 1) - tile_of(box.x0) + 1} * (tile_of(box.y1 - 1) - tile_of(box.y0) + 1);
  }
  /// tile(number) for each tile that the box touches, and, where `face` tells, that the face may touch: a sliver across
  /// many tiles fills little of its rectangle.
  template <class Callback>
  void for_each(const PixelBox& box, const QuickFace& face, const Callback& tile) const {
    if (box.empty()) return;
    const std::int32_t first = tile_of(box.x0), last = tile_of(box.x1 - 1);
    const std::int32_t last_row = tile_of(box.y1 - 1);
    for (std::int32_t row = tile_of(box.y0); row <= last_row; ++row) {
      std::int32_t from = first, to = last;
      if (face.usable()) {
        const PixelBox part = touched_pixels(face.in_rows(row << shift_, (row + 1) << shift_), box);
        from = tile_of(part.x0);
        to = part.x0 < part.x1 ? tile_of(part.x1 - 1) : from - 1;
      }
      for (std::int32_t column = from; column <= to; ++column) tile(static_cast<std::size_t>(row * across_ + column));
    }
  }

 private:
  std::int32_t tile_of(std::int32_t pixel) const { return pixel >> shift_; }

  PixelBox frame_;
  int shift_ = 0;
  std::int32_t across_ = 0, down_ = 0;
};

/// What of the faces of a list lies far apart in memory is asked for ahead: the corners of one to come, and the one
/// that comes after as many again.
inline void prefetch(const ClassifyView& view, std::span<const FaceId> faces, std::size_t at) {
  constexpr std::size_t kAhead = 8;
  if (at + 2 * kAhead >= faces.size()) return;
  __builtin_prefetch(&view.mesh.faces[index(faces[at + 2 * kAhead])]);
  for (const std::uint32_t vertex : view.mesh.faces[index(faces[at + kAhead])]) {
    __builtin_prefetch(&view.projected.positions[vertex]);
    __builtin_prefetch(&view.projected.vertices[vertex]);
  }
}

/// Lists are made by so many parts, whatever the number of threads: enough for every thread to have some.
inline constexpr std::size_t kListParts = 64;

/// Faces by tile: what parts list at once, sorted by counting. Within a tile faces come part by part, as they were
/// listed.
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

  /// Forgets everything but the memory.
  void start(std::size_t parts, std::size_t tiles);
  /// One thread a part.
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
