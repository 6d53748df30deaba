#include "atlas/charts/chart_raster.h"

#include <algorithm>
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
  const auto band_of = [&](double y) { return std::clamp(static_cast<int>(std::floor(y / kBandRows)), 0, bands - 1); };
  return group_items<std::uint32_t>(static_cast<std::size_t>(bands), [&](const auto& emit) {
    for (const auto face : chart.faces) {
      const TexelTriangle& t = corners[face];
      const int low = band_of(std::min({t[0].y, t[1].y, t[2].y}) - 1.5);
      const int high = band_of(std::max({t[0].y, t[1].y, t[2].y}) + 1.5);
      for (int b = low; b <= high; ++b) emit(static_cast<std::size_t>(b), face);
    }
  });
}

CellBox band_box(const Chart& chart, int band) {
  const int bands = std::max(1, (chart.height + kBandRows - 1) / kBandRows);
  return {-1, band == 0 ? -1 : band * kBandRows, chart.width + 1,
          band == bands - 1 ? chart.height + 1 : (band + 1) * kBandRows};
}

}  // namespace gpvc::atlas
