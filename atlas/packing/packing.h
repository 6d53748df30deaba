// Placing shapes of cells on pages.
//
// Shapes are placed, large ones first, at the first free position (by row, then column) of the first page that has one,
// in the quarter turn whose last row comes first. Small shapes thus fill the gaps that large ones leave. Several orders
// and page widths are tried, and the packing with the fewest pages, then the fewest cells, is kept. Where one page is not
// enough, shapes are placed page by page, in ascending order of rank, so that few ranks share a page.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace gpvc::atlas {

/// Cells first..first+length-1 of a row.
struct CellRun {
  std::int32_t row = 0, first = 0, length = 0;
};

/// The cells of a box that a shape takes. Runs ascend by row and do not touch within a row.
struct PackShape {
  int width = 0, height = 0;  ///< of the box, cells
  std::vector<CellRun> runs;
  std::uint32_t rank = 0;  ///< pages ascend by rank; a shape may also fill a gap of the page before those of its rank
};

/// The place of a shape's box, in cells. A quarter turn clockwise moves cell (x, y) of a box of height h to
/// (h - 1 - y, x).
struct Placement {
  std::uint32_t page = 0;
  int x = 0, y = 0;  ///< top-left corner of the turned box
  int turns = 0;     ///< quarter turns clockwise, 0..3
};

struct PageSize {
  int width = 0, height = 0;
};

struct Packing {
  std::vector<Placement> placements;  ///< per shape
  std::vector<PageSize> pages;        ///< in cells, cropped to their content
};

/// Places every shape on pages of at most page_size x page_size cells. The content of the last page is laid out
/// near-square. Deterministic. Memory: about page_size^2 log2(page_size) / 8 bytes for each attempt, of which as many run
/// at once as there are threads and as 256 MB hold, one at least.
/// \pre every shape's box fits page_size x page_size
Packing pack_shapes(std::span<const PackShape> shapes, int page_size);

}  // namespace gpvc::atlas
