// Which face owns each texel of a chart.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/charts/charts.h"
#include "io/image.h"

namespace gpvc::atlas {

/// How close a texel is to the face that owns it, nearest first.
enum class TexelReach : std::uint8_t {
  outside = 0,
  centre = 1,   ///< its centre lies in the owner
  touched = 2,  ///< the owner touches it
  ring = 3,     ///< a bilinear lookup at some point of the owner reads it
};

inline constexpr std::uint32_t kNoOwner = 0xFFFFFFFFu;

/// Texels of a box of a chart, row-major. Rings reach one texel beyond the box of the whole chart.
struct ChartRaster {
  CellBox box;                       ///< in the chart's texels
  std::vector<std::uint32_t> owner;  ///< mesh face
  std::vector<TexelReach> reach;
  int width() const { return box.x1 - box.x0; }
  int height() const { return box.y1 - box.y0; }
  std::size_t at(int x, int y) const { return pixel_index(x - box.x0, y - box.y0, width()); }
};

/// A texel's owner is the face with the nearest reach, the first of `faces` where several have it. `faces` are those
/// that may reach into the box. O(texels + faces).
ChartRaster rasterize(std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners, const CellBox& box);

inline constexpr int kBandRows = 64;

/// Texels from a band within which faces matter to it. Their rings reach one; on a grid of cells of two (blending), a face
/// reaches two, to the middle of a row of cells one beyond the band. One more is for rounding.
inline constexpr double kBandReach = 4;

/// Faces of a chart, grouped by the bands of kBandRows rows that are less than kBandReach away.
using FaceBands = Grouped<std::uint32_t>;

FaceBands face_bands(const Chart& chart, std::span<const TexelTriangle> corners);

/// The texels of a band. The first and last bands include the rows of the rings.
CellBox band_box(const Chart& chart, int band);

}  // namespace gpvc::atlas
