#include "atlas/baking/bake.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "atlas/baking/each_photo.h"

namespace gpvc::atlas {

namespace {

/// Longest edge, in frame pixels, of texels that are the mean of their whole square.
constexpr double kWholeTexel_px = 16;

bool is_coarse(const Chart& chart) { return chart.scale * kWholeTexel_px < 1; }

/// Edge of the squares that are baked together, texels: photo positions are interpolated in them where texels are not
/// coarse.
int block_texels(const Chart& chart, int step) {
  if (is_coarse(chart)) return kStripRow;
  return std::clamp(static_cast<int>(step * chart.scale), 1, kStripRow);
}

PixelPoint texel_centre(const Chart& chart, int x, int y) { return chart.frame_position(x + 0.5, y + 0.5); }

/// A rectangle of a view's frame.
struct FrameRectangle {
  double x0, y0, x1, y1;
};

/// What coarse texels may read: the faces' bounds and a border. So a chart's texels read every pixel a few times at
/// most, however coarse they are, and a texel larger than its chart has the chart's colour, not all the photo's.
FrameRectangle readable(const Chart& chart, std::span<const std::uint32_t> faces,
                        std::span<const TexelTriangle> corners) {
  FrameRectangle r{HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (const auto face : faces) {
    for (const TexelPoint& corner : corners[face]) {
      const PixelPoint p = chart.frame_position(corner.x, corner.y);
      r = {std::min(r.x0, p.x), std::min(r.y0, p.y), std::max(r.x1, p.x), std::max(r.y1, p.y)};
    }
  }
  // Texels exceed the bounds by two of their edges, the ring being one. Up to kWholeTexel_px all of that is read; from
  // there on less, as the share of a small chart in its texel falls.
  const double border = 2 * kWholeTexel_px * kWholeTexel_px * chart.scale;
  return {r.x0 - border, r.y0 - border, r.x1 + border, r.y1 + border};
}

struct Interval {
  double low, high;
};

/// The part within limits, drawn inwards to half the texel where less is left: along the bounds there may be little of
/// the faces.
Interval clipped(const Interval& texel, const Interval& limits) {
  const double least = std::min((texel.high - texel.low) / 2, limits.high - limits.low);
  const double low = std::clamp(texel.low, limits.low, std::max(limits.low, limits.high - least));
  return {low, std::min(std::max(texel.high, low + least), limits.high)};
}

FrameRectangle clipped_texel(const Chart& chart, int x, int y, const FrameRectangle& limits) {
  const PixelPoint low = chart.frame_position(x, y), high = chart.frame_position(x + 1.0, y + 1.0);
  const Interval across = clipped({low.x, high.x}, {limits.x0, limits.x1}),
                 down = clipped({low.y, high.y}, {limits.y0, limits.y1});
  return {across.low, down.low, across.high, down.high};
}

/// Lets the caller stop the work while a photo is still being used: progress may throw.
class Poll {
 public:
  Poll(const Progress& progress, std::size_t done, std::size_t total)
      : progress_(progress), done_(done), total_(total) {}

  /// From any thread.
  void operator()() {
    if (!progress_) return;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || Clock::now() < next_) return;
    next_ = Clock::now() + kInterval;
    progress_(done_, total_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kInterval{100};
  const Progress& progress_;
  std::size_t done_, total_;
  std::mutex mutex_;
  Clock::time_point next_{};  ///< not before
};

/// A band of a chart on its way to its page.
struct Band {
  std::uint32_t id;  ///< of the chart
  const Chart& chart;
  const ChartPlace& place;
  std::span<const std::uint32_t> faces;
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

  void bake(const Band& band, Page& page, Poll& poll) const {
    const CellBox& box = band.raster.box;
    const bool coarse = is_coarse(band.chart);
    const FrameRectangle limits = coarse ? readable(band.chart, band.faces, band.corners) : FrameRectangle{};
    const int block = block_texels(band.chart, step_);
    std::vector<StripSample> near;
    for (int y = box.y0; y < box.y1; y += block) {
      poll();
      for (int x = box.x0; x < box.x1; x += block) {
        const CellBox part{x, y, std::min(x + block, box.x1), std::min(y + block, box.y1)};
        if (!any_wanted(band.raster, part)) continue;
        near.clear();
        if (const ChartStrip* strip = correction_.strip(band.id)) gather_strip(*strip, part, near);
        if (coarse)
          average_block(band, part, near, limits, page, poll);
        else if (view_.camera.distortion.is_identity() && band.chart.scale == 1)
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

  /// `frame`: where the colour is from.
  void put(const Band& band, int x, int y, const PixelPoint& frame, Color color, const Color& strip, Page& page) const {
    const std::size_t i = band.raster.at(x, y);
    if (!correction_.identity()) {
      const std::uint32_t owner = band.raster.owner[i];
      color = correction_.expose(color, id_, frame) +
              correction_.face_offset(owner, band.corners[owner], x + 0.5, y + 0.5) + strip;
    }
    const auto texel = band.place.texel(x, y);
    page.put(texel.x, texel.y, color, band.raster.reach[i] == TexelReach::ring ? TexelState::ring : TexelState::chart);
  }

  static std::array<Color, kStripRow> strip_row(std::span<const StripSample> near, int x, int y) {
    return near.empty() ? std::array<Color, kStripRow>{} : strip_offsets(near, x + 0.5, y + 0.5);
  }

  void copy_block(const Band& band, const CellBox& part, std::span<const StripSample> near, Page& page) const {
    const int shift_x = static_cast<int>(band.chart.origin_x), shift_y = static_cast<int>(band.chart.origin_y);
    for (int y = part.y0; y < part.y1; ++y) {
      const auto strip = strip_row(near, part.x0, y);
      for (int x = part.x0; x < part.x1; ++x) {
        const int px = shift_x + x, py = shift_y + y;
        if (!wanted(band.raster, x, y) || px < 0 || py < 0 || px >= photo_.width || py >= photo_.height) continue;
        put(band, x, y, texel_centre(band.chart, x, y), load(photo_.at(px, py)),
            strip[static_cast<std::size_t>(x - part.x0)], page);
      }
    }
  }

  void sample_block(const Band& band, const CellBox& part, std::span<const StripSample> near, Page& page) const {
    const PixelPoint low = band.chart.frame_position(part.x0, part.y0);
    const PixelPoint high = band.chart.frame_position(part.x1, part.y1);
    const PhotoPositions positions(view_.camera, low.x, low.y, high.x, high.y);
    for (int y = part.y0; y < part.y1; ++y) {
      const auto strip = strip_row(near, part.x0, y);
      for (int x = part.x0; x < part.x1; ++x) {
        if (!wanted(band.raster, x, y)) continue;
        if (const auto color = sample(band.chart, positions, x, y))
          put(band, x, y, texel_centre(band.chart, x, y), *color, strip[static_cast<std::size_t>(x - part.x0)], page);
      }
    }
  }

  void average_block(const Band& band, const CellBox& part, std::span<const StripSample> near,
                     const FrameRectangle& limits, Page& page, Poll& poll) const {
    for (int y = part.y0; y < part.y1; ++y) {
      const auto strip = strip_row(near, part.x0, y);
      for (int x = part.x0; x < part.x1; ++x) {
        if (!wanted(band.raster, x, y)) continue;
        const FrameRectangle r = clipped_texel(band.chart, x, y, limits);
        if (const auto color = mean(r, poll))
          put(band, x, y, {(r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2}, *color, strip[static_cast<std::size_t>(x - part.x0)],
              page);
      }
    }
  }

  /// Within the photo, or the half pixel beyond that a bilinear lookup at its very border reads.
  bool in_photo(const PhotoPoint& q) const {
    return q.x >= -0.5 && q.y >= -0.5 && q.x <= photo_.width + 0.5 && q.y <= photo_.height + 0.5;
  }

  /// Of the photo's part of a rectangle, a sample a pixel. Lens models bend too much over a coarse texel to be
  /// interpolated, and so many samples need not be sharp. nullopt outside the photo.
  std::optional<Color> mean(const FrameRectangle& r, Poll& poll) const {
    const auto samples = [](double length) { return std::max(1, static_cast<int>(std::ceil(length))); };
    const int columns = samples(r.x1 - r.x0), rows = samples(r.y1 - r.y0);
    std::array<double, 3> sum{};  // of up to a whole photo: more than floats add without loss
    std::size_t count = 0;
    for (int j = 0; j < rows; ++j) {
      poll();
      for (int i = 0; i < columns; ++i) {
        const PixelPoint p{r.x0 + (i + 0.5) / columns * (r.x1 - r.x0), r.y0 + (j + 0.5) / rows * (r.y1 - r.y0)};
        const auto q = photo_from_pixel(view_.camera, p);
        if (!q || !in_photo(*q)) continue;
        const Color color = sample_bilinear(photo_, q->x, q->y);
        sum[0] += double{color.r}, sum[1] += double{color.g}, sum[2] += double{color.b};
        ++count;
      }
    }
    if (!count) return std::nullopt;
    const auto share = [&](double s) { return static_cast<float>(s / static_cast<double>(count)); };
    return Color{share(sum[0]), share(sum[1]), share(sum[2])};
  }

  /// One bicubic sample where texels are as fine as pixels; the mean over the texel's square where coarser. nullopt
  /// outside the photo.
  std::optional<Color> sample(const Chart& chart, const PhotoPositions& positions, int x, int y) const {
    const int taps = chart.scale >= 1 ? 1 : static_cast<int>(std::ceil(1 / chart.scale));
    Color sum;
    int count = 0;
    for (int j = 0; j < taps; ++j) {
      for (int i = 0; i < taps; ++i) {
        const PixelPoint p = chart.frame_position(x + (i + 0.5) / taps, y + (j + 0.5) / taps);
        const auto q = positions.at(p.x, p.y);
        if (!q || !in_photo(*q)) continue;
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

std::vector<ViewWork> gather_work(const AtlasInput& input, const ChartSet& set, std::span<const FaceBands> bands,
                                  std::span<const PartialChart> partial) {
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
                 const ColorCorrection& correction, int padding, std::span<Page> pages, std::span<PartialChart> partial,
                 const Progress& progress) {
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
    Poll poll(progress, done, views.size());
    tbb::parallel_for(std::size_t{0}, plain_bands.size() + partial_charts.size(), [&](std::size_t i) {
      poll();
      if (i >= plain_bands.size())
        return take_view(partial[partial_charts[i - plain_bands.size()]], set, input.coverage, view, ViewId{v}, photo,
                         correction);
      const auto [c, b] = plain_bands[i];
      const Chart& chart = set.charts[c];
      const auto faces = bands[c].band(b);
      const ChartRaster raster = rasterize(faces, set.corners, band_box(chart, b));
      baker.bake({c, chart, places[c], faces, set.corners, raster}, pages[places[c].page], poll);
    });
    if (progress) progress(++done, views.size());
  });
}

}  // namespace gpvc::atlas
