// The sums of coarse colours that are added to the texels of a plain chart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/baking/baking.h"
#include "atlas/baking/color_hulls.h"
#include "atlas/baking/face_share.h"
#include "atlas/blending/coarse_photo.h"
#include "atlas/charts/chart_raster.h"

namespace gpvc::atlas {

/// Bytes that a chart's sums take, about.
std::size_t blend_bytes(const ChartSet& set, std::uint32_t chart);

/// Sums for one chart, on a grid, of 10 bytes a cell; its bands can be worked on side by side.
class BlendField {
 public:
  /// Borrows the build. No sums are kept yet.
  BlendField(const AtlasBuild& build, std::uint32_t chart);

  /// Finds the bands, and the cells and views of each. Before all that follows. TBB.
  void open();
  std::size_t bands() const { return bands_.size(); }
  /// Views that add something to a band, in ascending order.
  std::span<const std::uint32_t> views_of(std::size_t band) const { return bands_[band].views; }
  /// Adds what a view gives to a band. \param coarse its photo \param step see lattice_step
  void add(std::size_t band, ViewId id, const CoarseRows& coarse, int step);
  /// Adds the sums to the texels on the chart's page. After all views. TBB.
  void apply(AtlasBuild& build) const;
  /// What the sums, after all views, make of colours.
  InventedColor invented_color() const;

 private:
  struct Cell {
    std::uint16_t x, y;  ///< in the band's box
  };
  /// The cells that the texels of a band take colours from. Boxes of ragged charts are mostly empty, so only cells in faces
  /// and beside them have sums.
  struct Band {
    std::vector<std::uint32_t> faces, views;
    Grouped<Cell> cells;  ///< by face, row-major
    std::vector<ColorSum> sums;
    ColorHulls hulls;
  };

  CellBox box_of(std::size_t band) const;
  void open_band(std::size_t band);
  void apply_band(std::size_t band, AtlasBuild& build) const;

  const AtlasBuild& build_;
  std::uint32_t number_;
  const Chart& chart_;
  FaceBands faces_;
  std::vector<Band> bands_;
};

}  // namespace gpvc::atlas
