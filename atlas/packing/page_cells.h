// Occupied cells of a page, and the search for places where a shape fits between them.
//
// All columns of a row are tested at once with machine words, one bit per column. A shape whose box starts at column x
// collides in a row if any cell of its run, x + first .. x + first + length - 1, is occupied. The columns blocked by a
// run of length 2^k, for any k, are kept as level k of a sparse table:
//
//     level 0   #..#......    bit x: cell x is occupied
//     level 1   #.##......    bit x: any of the 2 cells x, x + 1
//     level 2   ####......    bit x: any of the 4 cells x .. x + 3
//
// A run of any other length is the union of two overlapping runs of 2^k cells, so every run of the shape costs two
// shifted look-ups per word. A run of length 3 that starts at the shape's column 1:
//
//     level 1 shifted left by 1     .##.......    cells x + 1, x + 2
//     level 1 shifted left by 2     ##........    cells x + 2, x + 3
//     blocked columns               ###.......    the first free column is 3
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/packing/packing.h"

namespace gpvc::atlas {

/// A shape in one of its quarter turns.
struct TurnedShape : PackShape {
  TurnedShape() = default;
  explicit TurnedShape(PackShape shape);

  std::vector<std::uint32_t> check_order;  ///< of runs: spread over the rows, so that collisions are found early
};

/// Turned clockwise.
PackShape quarter_turn(const PackShape& shape);

struct Position {
  int x = 0, y = 0;  ///< cells
};

class PageCells {
 public:
  PageCells(int width, int height);
  int height() const { return height_; }
  /// What a page of that size takes, about.
  static std::size_t bytes(int width, int height);

  /// The first position, by row and then column, at row first_row or later where the shape collides with no occupied
  /// cell and ends before row `limit`.
  std::optional<Position> find(const TurnedShape& shape, int first_row, int limit);
  void occupy(const TurnedShape& shape, const Position& at);

 private:
  std::uint64_t* row(int level, int y) {
    return bits_.data() +
           (static_cast<std::size_t>(level) * static_cast<std::size_t>(height_) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(words_);
  }
  void add_shifted(const std::uint64_t* bits, int shift, int first, int end, std::uint64_t* to) const;
  bool may_fit(const TurnedShape& shape, int y) const;
  std::optional<int> find_in_row(const TurnedShape& shape, int y);
  void refresh(int y, int first, int end);

  static constexpr int kWordBits = 64;
  static int words_of(int width);
  static int levels_of(int width);
  int width_, height_, words_, levels_;
  std::vector<std::uint64_t> bits_;  ///< by level, row and word
  std::vector<int> longest_free_;    ///< per row: length of its longest free run
  std::vector<std::uint64_t> blocked_columns_;
};

}  // namespace gpvc::atlas
