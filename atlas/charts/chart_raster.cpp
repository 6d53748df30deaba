#include "atlas/charts/chart_raster.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace gpvc::atlas {

ChartRaster rasterize(std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners,
                      const CellBox& box) {
  ChartRaster raster;
  raster.box = box;
  const std::size_t texels = static_cast<std::size_t>(raster.width()) * static_cast<std::size_t>(raster.height());
  raster.owner.assign(texels, kNoOwner);
  raster.reach.assign(texels, TexelReach::outside);
  // A bilinear lookup reads texels whose centres are less than one texel away along each axis.
  for (const auto& [half, reach] :
       {std::pair(0.0, TexelReach::centre), std::pair(0.5, TexelReach::touched), std::pair(1.0, TexelReach::ring)}) {
    for (const auto face : faces) {
      triangle_spans(corners[face], half, box, [&, r = reach](int y, int first, int last) {
        const std::size_t line = raster.at(box.x0, y);
        for (int x = first; x <= last; ++x) {
          const std::size_t i = line + static_cast<std::size_t>(x - box.x0);
          if (raster.owner[i] != kNoOwner) continue;
          raster.owner[i] = face;
          raster.reach[i] = r;
        }
      });
    }
  }
  return raster;
}

FaceBands face_bands(const Chart& chart, std::span<const TexelTriangle> corners) {
  const int bands = std::max(1, (chart.height + kBandRows - 1) / kBandRows);
  const auto range = [&](std::uint32_t face) {
    const TexelTriangle& t = corners[face];
    const double low = std::min({t[0].y, t[1].y, t[2].y}) - 1.5, high = std::max({t[0].y, t[1].y, t[2].y}) + 1.5;
    return std::pair(std::clamp(static_cast<int>(std::floor(low / kBandRows)), 0, bands - 1),
                     std::clamp(static_cast<int>(std::floor(high / kBandRows)), 0, bands - 1));
  };
  FaceBands result;
  result.first.assign(static_cast<std::size_t>(bands) + 1, 0);
  for (const auto face : chart.faces) {
    const auto [low, high] = range(face);
    for (int b = low; b <= high; ++b) ++result.first[static_cast<std::size_t>(b) + 1];
  }
  std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
  result.faces.resize(result.first.back());
  std::vector<std::size_t> next(result.first.begin(), result.first.end() - 1);
  for (const auto face : chart.faces) {
    const auto [low, high] = range(face);
    for (int b = low; b <= high; ++b) result.faces[next[static_cast<std::size_t>(b)]++] = face;
  }
  return result;
}

CellBox band_box(const Chart& chart, int band) {
  const int bands = std::max(1, (chart.height + kBandRows - 1) / kBandRows);
  return {-1, band == 0 ? -1 : band * kBandRows, chart.width + 1,
          band == bands - 1 ? chart.height + 1 : (band + 1) * kBandRows};
}

}  // namespace gpvc::atlas
