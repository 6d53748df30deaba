// The sums of coarse colours that are added to the texels of a plain chart.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/baking/baking.h"
#include "atlas/blending/blend_weights.h"
#include "atlas/blending/coarse_photo.h"

namespace gpvc::atlas {

/// Texels along the edge of a cell of the grid on which sums are kept: a pixel of a coarse photo, where texels are as fine as
/// the photo's pixels. Larger texels need no finer grid.
inline constexpr int kBlendStep = kCoarsePixel;

/// Rows of cells that are worked on together.
inline constexpr int kBlendRows = 32;

/// Sums for one chart, on a grid, of 10 bytes a cell; bands of rows can be worked on side by side. They are whole numbers, so
/// they depend on no order of the views.
class BlendField {
 public:
  /// Borrows the build. No sums are kept yet.
  BlendField(const AtlasBuild& build, std::uint32_t chart);

  std::size_t bands() const { return faces_.groups(); }
  /// Views that add something to a band, in ascending order.
  std::vector<std::uint32_t> views_of(std::size_t band) const;
  /// Finds the cells' faces. For each band; then begin(), before add().
  void open(std::size_t band);
  void begin();
  /// Adds what a view gives to a band. \param coarse its photo
  void add(std::size_t band, ViewId id, const CoarsePhoto& coarse);
  /// Adds the sums to the chart's texels on its page. After all views.
  void apply(AtlasBuild& build) const;

 private:
  class FaceShare;

  /// Grey levels times kUnit.
  using Sum = std::array<std::int16_t, 3>;

  /// Numbers of all cells of the box, row-major; rows are filled up to whole words of bits.
  std::size_t cell_at(int column, int row) const { return pixel_index(column - box_.x0, row - box_.y0, row_cells_); }
  /// Where a cell's sum is. \pre it has one
  std::size_t sum_of(std::size_t cell) const;
  bool has_sum(std::size_t cell) const { return (has_[cell / 64] >> (cell % 64) & 1) != 0; }
  /// Adds the sums of a row of cells to the means of their columns.
  void add_row(int row, float weight, std::span<ColorMean> columns) const;

  const AtlasBuild& build_;
  std::uint32_t number_;
  const Chart& chart_;
  const ChartPlace& place_;
  CellBox box_;                                     ///< of cells
  int row_cells_ = 0;                               ///< cells of the box in a row, a multiple of 64
  Grouped<std::uint32_t> faces_;                    ///< by band, those with sums
  std::vector<Grouped<std::uint32_t>> face_cells_;  ///< per band: by face of the band, its cells
  // Boxes of ragged charts are mostly empty, so only cells in faces and beside them have sums.
  std::vector<std::uint64_t> has_;     ///< a bit for each cell
  std::vector<std::uint32_t> before_;  ///< per word of bits: sums of the cells before
  std::vector<Sum> sums_;
};

}  // namespace gpvc::atlas
