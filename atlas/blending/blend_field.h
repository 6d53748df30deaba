// The sums of coarse colours that are added to the texels of a plain chart.
#pragma once

#include <array>
#include <cstdint>
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

/// Sums for one chart, on a grid; bands of rows can be worked on side by side. They are whole numbers, so they depend on no
/// order of the views.
class BlendField {
 public:
  /// Borrows both. No sums are kept yet.
  BlendField(const AtlasBuild& build, const BlendWeights& weights, std::uint32_t chart);

  std::size_t bands() const { return faces_.groups(); }
  /// Views that add something to a band, in ascending order.
  std::vector<std::uint32_t> views_of(std::size_t band) const;
  /// Finds the cells' faces. For each band, before add().
  void open(std::size_t band);
  /// Adds what a view gives to a band. \param coarse its photo
  void add(std::size_t band, ViewId id, const CoarsePhoto& coarse);
  /// Adds the sums to the chart's texels on its page. After all views.
  void apply(AtlasBuild& build) const;

 private:
  struct Cell {
    std::array<std::int16_t, 3> sum{};  ///< grey levels times kUnit
    std::int16_t known = 0;             ///< 1 in faces and beside them
  };
  class FaceShare;

  std::size_t at(int column, int row) const { return pixel_index(column - box_.x0, row - box_.y0, box_.x1 - box_.x0); }
  /// The colour to be added at a position in texels.
  Color sum_at(double x, double y) const;

  const AtlasBuild& build_;
  const BlendWeights& weights_;
  std::uint32_t number_;
  const Chart& chart_;
  const ChartPlace& place_;
  CellBox box_;                                     ///< of cells
  Grouped<std::uint32_t> faces_;                    ///< by band, those with sums
  std::vector<Grouped<std::uint32_t>> face_cells_;  ///< per band: by face of the band, its cells
  std::vector<Cell> cells_;
};

}  // namespace gpvc::atlas
