// Placing charts on pages, by shape.
//
// A shape is a bitmap of cells. Shapes are placed, large ones first, at the lowest free position
// (first row, then column) of the first page that has one, in the quarter turn that ends lowest. Small shapes
// thus fill what large ones leave. All columns of a row are tested at once with machine words, so a position
// costs next to nothing; several orders and page widths are tried and the one with the fewest texels is kept:
//
//     page            shape          blocked columns of this row
//     ##..##....      ##             ##.##.....  <- occupied, spread to the left by the shape's runs
//     #...#.....      #.             ...
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

/// Which cells of a box are needed. Runs ascend by row and do not touch within one.
struct PackShape {
  int width = 0, height = 0;  ///< of the box, cells
  std::vector<CellRun> runs;
};

/// A shape that fills its whole box.
PackShape box_shape(int width, int height);

/// Where a shape's box goes, in cells. A quarter turn clockwise takes cell (x, y) of a box of height h to
/// (h - 1 - y, x).
struct Placement {
  std::uint32_t page = 0;
  int x = 0, y = 0;  ///< where the turned box's top-left corner goes
  int turns = 0;     ///< quarter turns clockwise, 0..3
};

struct PageSize {
  int width = 0, height = 0;
};

struct Packing {
  std::vector<Placement> placements;  ///< per shape
  std::vector<PageSize> pages;        ///< in cells, cropped to their content
};

/// Places every shape on pages of at most page_size x page_size cells; when the last page is not full its content is
/// laid out near-square. Deterministic. Memory: about page_size^2 log2(page_size) / 8 bytes a page and attempt, as many
/// attempts at once as there are threads.
/// \pre every shape's box fits page_size x page_size
Packing pack_shapes(std::span<const PackShape> shapes, int page_size);

}  // namespace gpvc::atlas
