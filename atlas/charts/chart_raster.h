// Which face owns which texel of a chart.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/charts/charts.h"

namespace gpvc::atlas {

/// How a texel lies to its chart's faces, nearest first.
enum class TexelReach : std::uint8_t {
  outside = 0,
  centre = 1,   ///< its centre lies in the owner
  touched = 2,  ///< the owner touches it
  ring = 3,     ///< a bilinear lookup at some point of the owner reads it
};

inline constexpr std::uint32_t kNoOwner = 0xFFFFFFFFu;

/// Texels of a box of a chart, row-major. The ring lies one texel outside the chart's box.
struct ChartRaster {
  CellBox box;                       ///< in the chart's texels
  std::vector<std::uint32_t> owner;  ///< mesh face
  std::vector<TexelReach> reach;
  int width() const { return box.x1 - box.x0; }
  int height() const { return box.y1 - box.y0; }
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y - box.y0) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(x - box.x0);
  }
};

/// A texel belongs to the first face of its nearest reach. `faces` are those that may reach into the box. O(texels +
/// faces).
ChartRaster rasterize(std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners, const CellBox& box);

/// Faces of a chart by bands of kBandRows rows, their rings included.
struct FaceBands {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> faces;
  int bands() const { return static_cast<int>(first.size()) - 1; }
  std::span<const std::uint32_t> band(int b) const {
    const auto i = static_cast<std::size_t>(b);
    return std::span(faces).subspan(first[i], first[i + 1] - first[i]);
  }
};

inline constexpr int kBandRows = 64;

FaceBands face_bands(const Chart& chart, std::span<const TexelTriangle> corners);

/// Rows of a band; the first and last bands hold the ring's rows, too.
CellBox band_box(const Chart& chart, int band);

}  // namespace gpvc::atlas
