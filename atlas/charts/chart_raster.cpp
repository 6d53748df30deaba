#include "atlas/charts/chart_raster.h"

#include <algorithm>
#include <iterator>

namespace gpvc::atlas {

namespace {

/// A bilinear lookup reads texels whose centres are less than this away along each axis.
constexpr double kRing = 1;

/// Squares of texels that are not all owned. Few faces reach one, and the others need not be looked at again.
class OpenCells {
 public:
  explicit OpenCells(const ChartRaster& raster)
      : box_(raster.box), columns_((raster.width() - 1) / kEdge + 1), open_(pixel_index(0, rows(), columns_), 0) {
    for (int y = 0; y < raster.height(); ++y) {
      const std::size_t line = pixel_index(0, y, raster.width()), cells = pixel_index(0, y / kEdge, columns_);
      for (int x = 0; x < raster.width(); ++x)
        if (raster.owner[line + static_cast<std::size_t>(x)] == kNoOwner)
          open_[cells + static_cast<std::size_t>(x / kEdge)] = 1;
    }
  }

  /// False if all texels of the box whose centres are within `half` of the triangle along each axis are owned.
  bool near(const TexelTriangle& t, double half) const {
    FrameBox bounds;
    bounds.add(t);
    const int x0 = cell(bounds.x0 - half - 1, box_.x0, columns_), x1 = cell(bounds.x1 + half + 1, box_.x0, columns_);
    const int y0 = cell(bounds.y0 - half - 1, box_.y0, rows()), y1 = cell(bounds.y1 + half + 1, box_.y0, rows());
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        if (open_[pixel_index(x, y, columns_)]) return true;
    return false;
  }

 private:
  static constexpr int kEdge = 8;  ///< texels
  int rows() const { return (box_.y1 - box_.y0 - 1) / kEdge + 1; }
  /// The cell of a position along an axis; the nearest one beyond the box.
  static int cell(double place, int origin, int count) {
    return static_cast<int>(std::clamp((place - origin) / kEdge, 0.0, count - 1.0));
  }
  CellBox box_;
  int columns_;
  std::vector<char> open_;
};

}  // namespace

ChartRaster rasterize(std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners,
                      const CellBox& box) {
  ChartRaster raster;
  raster.box = box;
  const std::size_t texels = static_cast<std::size_t>(raster.width()) * static_cast<std::size_t>(raster.height());
  raster.owner.assign(texels, kNoOwner);
  raster.reach.assign(texels, TexelReach::outside);
  const auto add = [&](std::uint32_t face, double half, TexelReach reach) {
    triangle_spans(corners[face], half, box, [&](int y, int first, int last) {
      const std::size_t line = raster.at(box.x0, y);
      for (int x = first; x <= last; ++x) {
        const std::size_t i = line + static_cast<std::size_t>(x - box.x0);
        if (raster.owner[i] != kNoOwner) continue;
        raster.owner[i] = face;
        raster.reach[i] = reach;
      }
    });
  };
  for (const auto face : faces) add(face, 0, TexelReach::centre);
  std::vector<std::uint32_t> outer;
  const OpenCells open(raster);
  std::ranges::copy_if(faces, std::back_inserter(outer), [&](auto face) { return open.near(corners[face], kRing); });
  for (const auto face : outer) add(face, 0.5, TexelReach::touched);
  for (const auto face : outer) add(face, kRing, TexelReach::ring);
  return raster;
}

FaceBands face_bands(const Chart& chart, std::span<const TexelTriangle> corners) {
  const int bands = std::max(1, (chart.height + kBandRows - 1) / kBandRows);
  const auto band_of = [&](double y) { return std::clamp(static_cast<int>(std::floor(y / kBandRows)), 0, bands - 1); };
  return group_items<std::uint32_t>(static_cast<std::size_t>(bands), [&](const auto& emit) {
    for (const auto face : chart.faces) {
      const TexelTriangle& t = corners[face];
      const int low = band_of(std::min({t[0].y, t[1].y, t[2].y}) - kBandReach);
      const int high = band_of(std::max({t[0].y, t[1].y, t[2].y}) + kBandReach);
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
