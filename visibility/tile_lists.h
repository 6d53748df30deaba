// An image in square tiles, and lists of the faces that may touch each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify.h"

namespace gpvc {

struct TileGrid {
  std::int32_t side = 1;  ///< of a tile, pixels
  std::size_t across = 0, down = 0;

  TileGrid() = default;
  TileGrid(const PixelBox& frame, std::int32_t tile_side)
      : side(tile_side),
        across(static_cast<std::size_t>((frame.x1 + tile_side - 1) / tile_side)),
        down(static_cast<std::size_t>((frame.y1 + tile_side - 1) / tile_side)) {}
  std::size_t count() const { return across * down; }
  /// Of the frame.
  PixelBox pixels(std::size_t tile, const PixelBox& frame) const {
    const auto x = static_cast<std::int32_t>(tile % across) * side;
    const auto y = static_cast<std::int32_t>(tile / across) * side;
    return {x, y, std::min(x + side, frame.x1), std::min(y + side, frame.y1)};
  }
  /// How many tiles the box touches.
  std::int64_t touched(const PixelBox& box) const {
    if (box.empty()) return 0;
    return std::int64_t{(box.x1 - 1) / side - box.x0 / side + 1} * ((box.y1 - 1) / side - box.y0 / side + 1);
  }
  /// tile(number) for each tile that the box touches, and, where `face` tells, that the face may touch: a
  /// sliver across many tiles fills little of its rectangle.
  template <class Callback>
  void for_each(const PixelBox& box, const QuickFace& face, const Callback& tile) const {
    if (box.empty()) return;
    const std::int32_t first_row = box.y0 / side, last_row = (box.y1 - 1) / side;
    const std::int32_t first = box.x0 / side, last = (box.x1 - 1) / side;
    const bool narrow = face.usable() && last - first > 1 && last_row - first_row > 1;
    for (std::int32_t row = first_row; row <= last_row; ++row) {
      std::int32_t from = first, to = last;
      if (narrow) {
        const PixelBox part = touched_pixels(face.in_rows(row * side, (row + 1) * side), box);
        from = part.x0 / side;
        to = part.x0 < part.x1 ? (part.x1 - 1) / side : from - 1;
      }
      for (std::int32_t column = from; column <= to; ++column)
        tile(static_cast<std::size_t>(row) * across + static_cast<std::size_t>(column));
    }
  }
};

/// Faces by tile: what parts list at once, sorted by counting. Within a tile faces come part by part, as they
/// were listed.
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

}  // namespace gpvc
