// Occupied cells of a page and where a shape fits between them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/packing/packing.h"

namespace gpvc::atlas {

/// A shape in one of its quarter turns, in cells.
struct CellShape {
  int width = 0, height = 0;
  std::vector<CellRun> runs;
  std::vector<std::uint32_t> check_order;  ///< of runs: spread over the rows, so that a misfit shows early
};

CellShape upright(const PackShape& shape);
/// Clockwise; without check_order.
CellShape quarter_turn(const CellShape& shape);
void order_checks(CellShape& shape);

struct Position {
  int x = 0, y = 0;  ///< cells
};

/// Level k of a row has bit x set when any of the cells x .. x + 2^k - 1 is occupied, so a run of any length is tested
/// with two look-ups a word.
class PageCells {
 public:
  PageCells(int width, int height);
  int height() const { return height_; }

  /// The lowest position in rows first_row .. where the shape meets no occupied cell and ends before row `limit`.
  std::optional<Position> find(const CellShape& shape, int first_row, int limit);
  void occupy(const CellShape& shape, const Position& at);

 private:
  std::uint64_t* row(int level, int y) {
    return bits_.data() +
           (static_cast<std::size_t>(level) * static_cast<std::size_t>(height_) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(words_);
  }
  std::uint64_t shifted(const std::uint64_t* bits, int word, int shift) const;
  bool may_fit(const CellShape& shape, int y) const;
  int find_in_row(const CellShape& shape, int y);
  void refresh(int y);

  int width_, height_, words_, levels_;
  std::vector<std::uint64_t> bits_;
  std::vector<int> longest_free_;  ///< per row: cells of its longest free run
  std::vector<std::uint64_t> blocked_;
};

}  // namespace gpvc::atlas
