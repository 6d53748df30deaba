#include "atlas/bake.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "atlas/each_photo.h"

namespace gpvc {

namespace {

/// Edge of the squares in which a texel row's photo positions are interpolated, texels.
int block_texels(const Chart& chart, int step) {
  return std::clamp(static_cast<int>(step * chart.scale), 1, kStripRow);
}

/// A band of a chart on its way to its page.
struct Band {
  std::uint32_t id;  ///< of the chart
  const Chart& chart;
  const ChartPlace& place;
  std::span<const TexelTriangle> corners;
  const ChartRaster& raster;
};

class PlainBaker {
 public:
  PlainBaker(ViewId id, const View& view, const Image& photo, const ColorCorrection& correction, int padding)
      : id_(id),
        view_(view),
        photo_(photo),
        correction_(correction),
        step_(lattice_step(view.camera)),
        ring_(padding > 0) {}

  void bake(const Band& band, Page& page) const {
    const CellBox& box = band.raster.box;
    const int block = block_texels(band.chart, step_);
    std::vector<StripSample> near;
    for (int y = box.y0; y < box.y1; y += block) {
      for (int x = box.x0; x < box.x1; x += block) {
        const CellBox part{x, y, std::min(x + block, box.x1), std::min(y + block, box.y1)};
        if (!any_wanted(band.raster, part)) continue;
        near.clear();
        if (const ChartStrip* strip = correction_.strip(band.id)) gather_strip(*strip, part, near);
        if (view_.camera.distortion.is_identity() && band.chart.scale == 1)
          copy_block(band, part, near, page);
        else
          sample_block(band, part, near, page);
      }
    }
  }

 private:
  bool wanted(const ChartRaster& raster, int x, int y) const {
    const TexelReach reach = raster.reach[raster.at(x, y)];
    return reach != TexelReach::outside && (ring_ || reach != TexelReach::ring);
  }

  bool any_wanted(const ChartRaster& raster, const CellBox& part) const {
    for (int y = part.y0; y < part.y1; ++y)
      for (int x = part.x0; x < part.x1; ++x)
        if (wanted(raster, x, y)) return true;
    return false;
  }

  void put(const Band& band, int x, int y, Color color, const Color& strip, Page& page) const {
    const std::size_t i = band.raster.at(x, y);
    if (!correction_.identity()) {
      const std::uint32_t owner = band.raster.owner[i];
      color = correction_.expose(color, id_, band.chart.frame_position(x + 0.5, y + 0.5)) +
              correction_.face_offset(owner, band.corners[owner], x + 0.5, y + 0.5) + strip;
    }
    const auto texel = band.place.texel(x, y);
    page.put(texel.x, texel.y, color,
             band.raster.reach[i] == TexelReach::ring ? TexelState::ring : TexelState::chart);
  }

  static std::array<Color, kStripRow> strip_row(std::span<const StripSample> near, int x, int y) {
    return near.empty() ? std::array<Color, kStripRow>{} : strip_offsets(near, x + 0.5, y + 0.5);
  }

  void copy_block(const Band& band, const CellBox& part, std::span<const StripSample> near,
                  Page& page) const {
    const int shift_x = static_cast<int>(band.chart.origin_x),
              shift_y = static_cast<int>(band.chart.origin_y);
    for (int y = part.y0; y < part.y1; ++y) {
      const auto strip = strip_row(near, part.x0, y);
      for (int x = part.x0; x < part.x1; ++x) {
        const int px = shift_x + x, py = shift_y + y;
        if (!wanted(band.raster, x, y) || px < 0 || py < 0 || px >= photo_.width || py >= photo_.height)
          continue;
        put(band, x, y, load(photo_.at(px, py)), strip[static_cast<std::size_t>(x - part.x0)], page);
      }
    }
  }

  void sample_block(const Band& band, const CellBox& part, std::span<const StripSample> near,
                    Page& page) const {
    const PixelPoint low = band.chart.frame_position(part.x0, part.y0);
    const PixelPoint high = band.chart.frame_position(part.x1, part.y1);
    const PhotoPositions positions(view_.camera, low.x, low.y, high.x, high.y);
    for (int y = part.y0; y < part.y1; ++y) {
      const auto strip = strip_row(near, part.x0, y);
      for (int x = part.x0; x < part.x1; ++x) {
        if (!wanted(band.raster, x, y)) continue;
        if (const auto color = sample(band.chart, positions, x, y))
          put(band, x, y, *color, strip[static_cast<std::size_t>(x - part.x0)], page);
      }
    }
  }

  /// One bicubic sample where texels are as fine as pixels; the mean over the texel's square where coarser.
  /// nullopt outside the photo, but for half a pixel that a bilinear lookup at its very border reads.
  std::optional<Color> sample(const Chart& chart, const PhotoPositions& positions, int x, int y) const {
    const int taps = chart.scale >= 1 ? 1 : static_cast<int>(std::ceil(1 / chart.scale));
    Color sum;
    int count = 0;
    for (int j = 0; j < taps; ++j) {
      for (int i = 0; i < taps; ++i) {
        const PixelPoint p = chart.frame_position(x + (i + 0.5) / taps, y + (j + 0.5) / taps);
        const auto q = positions.at(p.x, p.y);
        if (!q || q->x < -0.5 || q->y < -0.5 || q->x > photo_.width + 0.5 || q->y > photo_.height + 0.5)
          continue;
        sum = sum + sample_bicubic(photo_, q->x, q->y);
        ++count;
      }
    }
    if (!count) return std::nullopt;
    return (1.0f / static_cast<float>(count)) * sum;
  }

  ViewId id_;
  const View& view_;
  const Image& photo_;
  const ColorCorrection& correction_;
  int step_;
  bool ring_;
};

struct BandTask {
  std::uint32_t chart;
  int band;
};

/// What a view's photo is needed for.
struct ViewWork {
  std::vector<BandTask> bands;
  std::vector<std::uint32_t> partial;
  bool empty() const { return bands.empty() && partial.empty(); }
};

std::vector<ViewWork> gather_work(const AtlasInput& input, const ChartSet& set,
                                  std::span<const FaceBands> bands, std::span<const PartialChart> partial) {
  std::vector<ViewWork> work(input.scene.views.size());
  for (std::uint32_t c = 0; c < set.charts.size(); ++c)
    if (set.charts[c].kind == ChartKind::plain)
      for (int b = 0; b < bands[c].bands(); ++b) work[index(set.charts[c].view)].bands.push_back({c, b});
  for (std::uint32_t p = 0; p < partial.size(); ++p)
    for (const auto view : partial[p].views) work[view].partial.push_back(p);
  return work;
}

}  // namespace

void bake_photos(const AtlasInput& input, const ChartSet& set, std::span<const ChartPlace> places,
                 const ColorCorrection& correction, int padding, std::span<Page> pages,
                 std::span<PartialChart> partial, const Progress& progress) {
  std::vector<FaceBands> bands(set.charts.size());
  tbb::parallel_for(std::size_t{0}, bands.size(), [&](std::size_t c) {
    if (set.charts[c].kind == ChartKind::plain) bands[c] = face_bands(set.charts[c], set.corners);
  });
  const std::vector<ViewWork> work = gather_work(input, set, bands, partial);
  std::vector<std::uint32_t> views;
  for (std::uint32_t v = 0; v < work.size(); ++v)
    if (!work[v].empty()) views.push_back(v);

  std::size_t done = 0;
  each_photo(input.photos, views, [&](std::uint32_t v, const Image& photo) {
    const View& view = input.scene.views[v];
    const PlainBaker baker(ViewId{v}, view, photo, correction, padding);
    const auto& plain_bands = work[v].bands;
    const auto& partial_charts = work[v].partial;
    tbb::parallel_for(std::size_t{0}, plain_bands.size() + partial_charts.size(), [&](std::size_t i) {
      if (i >= plain_bands.size())
        return take_view(partial[partial_charts[i - plain_bands.size()]], set, input.coverage, view,
                         ViewId{v}, photo, correction);
      const auto [c, b] = plain_bands[i];
      const Chart& chart = set.charts[c];
      const ChartRaster raster = rasterize(bands[c].band(b), set.corners, band_box(chart, b));
      baker.bake({c, chart, places[c], set.corners, raster}, pages[places[c].page]);
    });
    if (progress) progress(++done, views.size());
  });
}

}  // namespace gpvc
