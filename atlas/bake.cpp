#include "atlas/bake.h"

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cmath>

namespace gpvc {

namespace {

/// Edge of the squares in which a texel row's photo positions are interpolated, texels.
int block_texels(const Chart& chart, int step) {
  return std::clamp(static_cast<int>(step * chart.scale), 1, kBandRows);
}

class PlainBaker {
 public:
  PlainBaker(const View& view, const Image& photo, const ColorCorrection& correction, Color gain, int padding)
      : view_(view),
        photo_(photo),
        correction_(correction),
        gain_(gain),
        step_(lattice_step(view.camera)),
        ring_(padding > 0),
        corrected_(gain.r != 1 || gain.g != 1 || gain.b != 1 || !correction.offsets.empty()) {}

  void bake(const Chart& chart, const ChartPlace& place, std::span<const TexelTriangle> corners,
            std::span<const std::uint32_t> faces, const CellBox& box, Page& page) const {
    const ChartRaster raster = rasterize(faces, corners, box);
    const bool copies = view_.camera.distortion.is_identity() && chart.scale == 1;
    if (copies) {
      for (int y = box.y0; y < box.y1; ++y)
        for (int x = box.x0; x < box.x1; ++x)
          if (wanted(raster, x, y)) copy(chart, place, corners, raster, x, y, page);
      return;
    }
    const int block = block_texels(chart, step_);
    for (int y = box.y0; y < box.y1; y += block)
      for (int x = box.x0; x < box.x1; x += block)
        bake_block(chart, place, corners, raster,
                   {x, y, std::min(x + block, box.x1), std::min(y + block, box.y1)}, page);
  }

 private:
  bool wanted(const ChartRaster& raster, int x, int y) const {
    const TexelReach reach = raster.reach[raster.at(x, y)];
    return reach != TexelReach::outside && (ring_ || reach != TexelReach::ring);
  }

  void put(const ChartPlace& place, std::span<const TexelTriangle> corners, const ChartRaster& raster, int x,
           int y, Color color, Page& page) const {
    const std::size_t i = raster.at(x, y);
    if (corrected_) {
      color = gain_ * color;
      if (!correction_.offsets.empty())
        color = color + correction_.offset(raster.owner[i], corners[raster.owner[i]], x + 0.5, y + 0.5);
    }
    const auto texel = place.texel(x, y);
    page.put(texel.x, texel.y, color,
             raster.reach[i] == TexelReach::ring ? TexelState::ring : TexelState::chart);
  }

  void copy(const Chart& chart, const ChartPlace& place, std::span<const TexelTriangle> corners,
            const ChartRaster& raster, int x, int y, Page& page) const {
    const int px = static_cast<int>(chart.origin_x) + x, py = static_cast<int>(chart.origin_y) + y;
    if (px < 0 || py < 0 || px >= photo_.width || py >= photo_.height) return;
    put(place, corners, raster, x, y, load(photo_.at(px, py)), page);
  }

  void bake_block(const Chart& chart, const ChartPlace& place, std::span<const TexelTriangle> corners,
                  const ChartRaster& raster, const CellBox& block, Page& page) const {
    bool any = false;
    for (int y = block.y0; y < block.y1 && !any; ++y)
      for (int x = block.x0; x < block.x1 && !any; ++x) any = wanted(raster, x, y);
    if (!any) return;
    const PixelPoint low = chart.frame_position(block.x0, block.y0),
                     high = chart.frame_position(block.x1, block.y1);
    const PhotoPositions positions(view_.camera, low.x, low.y, high.x, high.y);
    for (int y = block.y0; y < block.y1; ++y)
      for (int x = block.x0; x < block.x1; ++x)
        if (wanted(raster, x, y))
          if (const auto color = sample(chart, positions, x, y))
            put(place, corners, raster, x, y, *color, page);
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

  const View& view_;
  const Image& photo_;
  const ColorCorrection& correction_;
  Color gain_;
  int step_;
  bool ring_, corrected_;
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

Color ColorCorrection::offset(std::uint32_t face, const TexelTriangle& t, double x, double y) const {
  const double area = (t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[1].y - t[0].y) * (t[2].x - t[0].x);
  const auto& at = offsets[face];
  if (area == 0) return (1.0f / 3) * (at[0] + at[1] + at[2]);
  double b = ((x - t[0].x) * (t[2].y - t[0].y) - (y - t[0].y) * (t[2].x - t[0].x)) / area;
  double c = ((t[1].x - t[0].x) * (y - t[0].y) - (t[1].y - t[0].y) * (x - t[0].x)) / area;
  b = std::clamp(b, 0.0, 1.0), c = std::clamp(c, 0.0, 1.0);
  const double a = std::max(0.0, 1 - b - c), sum = a + b + c;
  return static_cast<float>(a / sum) * at[0] + static_cast<float>(b / sum) * at[1] +
         static_cast<float>(c / sum) * at[2];
}

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

  std::shared_ptr<const Image> photo, next;
  if (!views.empty()) next = input.photos.photo(ViewId{views.front()});
  for (std::size_t k = 0; k < views.size(); ++k) {
    photo = std::move(next);
    tbb::task_group ahead;
    if (k + 1 < views.size()) ahead.run([&] { next = input.photos.photo(ViewId{views[k + 1]}); });
    const std::uint32_t v = views[k];
    const View& view = input.scene.views[v];
    const Color gain = correction.gain.empty() ? Color{1, 1, 1} : correction.gain[v];
    const PlainBaker baker(view, *photo, correction, gain, padding);
    const auto& [plain_bands, partial_charts] = work[v];
    tbb::parallel_for(std::size_t{0}, plain_bands.size() + partial_charts.size(), [&](std::size_t i) {
      if (i >= plain_bands.size())
        return take_view(partial[partial_charts[i - plain_bands.size()]], set, view, ViewId{v}, *photo,
                         correction);
      const auto [c, band] = plain_bands[i];
      const Chart& chart = set.charts[c];
      baker.bake(chart, places[c], set.corners, bands[c].band(band), band_box(chart, band),
                 pages[places[c].page]);
    });
    ahead.wait();
    if (progress) progress(k + 1, views.size());
  }
}

}  // namespace gpvc
