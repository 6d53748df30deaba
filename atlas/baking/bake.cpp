// Fills pages with colour from the photos, view by view.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "atlas/baking/baking.h"
#include "io/clock.h"

namespace gpvc::atlas {

namespace {

/// Texels with a longer edge than this, in frame pixels, are coarse: they take the mean of a part of their square.
constexpr double kWholeTexelPx = 16;

bool is_coarse(const Chart& chart) { return chart.scale * kWholeTexelPx < 1; }

/// Edge, in texels, of the blocks that are baked together. Where texels are not coarse, photo positions are
/// interpolated within a block.
int block_texels(const Chart& chart, int step) {
  if (is_coarse(chart)) return kStripRow;
  return std::clamp(static_cast<int>(step * chart.scale), 1, kStripRow);
}

/// The part of the frame that coarse texels may read: the faces' bounding box and a border. So a chart's texels read
/// every pixel a few times at most, however coarse they are, and a texel larger than its chart has the chart's colour
/// rather than that of the whole photo.
FrameBox readable(const Chart& chart, std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners) {
  FrameBox box;
  for (const auto face : faces) {
    for (const TexelPoint& corner : corners[face]) {
      const PixelPoint p = chart.frame_position(corner.x, corner.y);
      box.add(p.x, p.y);
    }
  }
  // Texels reach two of their edges beyond the bounds, one of them for the ring. Up to kWholeTexelPx all of that is
  // read; beyond it less, because the share of a small chart in its texel falls.
  const double border = 2 * kWholeTexelPx * kWholeTexelPx * chart.scale;
  return {box.x0 - border, box.y0 - border, box.x1 + border, box.y1 + border};
}

struct Interval {
  double low, high;
};

/// The texel's part within the limits, but no less than half the texel (or all of the limits), moved inwards: along the
/// bounds a thin part would show little of the faces.
Interval clipped(const Interval& texel, const Interval& limits) {
  const double least = std::min((texel.high - texel.low) / 2, limits.high - limits.low);
  const double low = std::clamp(texel.low, limits.low, std::max(limits.low, limits.high - least));
  return {low, std::min(std::max(texel.high, low + least), limits.high)};
}

FrameBox clipped_texel(const Chart& chart, int x, int y, const FrameBox& limits) {
  const PixelPoint low = chart.frame_position(x, y), high = chart.frame_position(x + 1.0, y + 1.0);
  const Interval across = clipped({low.x, high.x}, {limits.x0, limits.x1}),
                 down = clipped({low.y, high.y}, {limits.y0, limits.y1});
  return {across.low, down.low, across.high, down.high};
}

/// Calls progress, which may throw to stop the work, while a photo is being baked.
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
  static constexpr std::chrono::milliseconds kInterval{100};
  const Progress& progress_;
  std::size_t done_, total_;
  std::mutex mutex_;
  Clock::time_point next_{};  ///< not before
};

/// Bakes rows of a plain chart.
class BandBaker {
 public:
  BandBaker(AtlasBuild& build, const ViewPhoto& photo, std::uint32_t chart, Poll& poll)
      : build_(build),
        photo_(photo),
        chart_(build.set.charts[chart]),
        place_(build.places[chart]),
        page_(build.page_of(chart)),
        strip_(build.correction.strip(chart)),
        poll_(poll) {}

  /// \param faces that reach into the band
  /// \param step see lattice_step
  void bake(int band, std::span<const std::uint32_t> faces, int step) {
    const CellBox box = band_box(chart_, band);
    raster_ = rasterize(faces, build_.set.corners, box);
    const bool coarse = is_coarse(chart_);
    const FrameBox limits = coarse ? readable(chart_, faces, build_.set.corners) : FrameBox{};
    const bool copied = photo_.view.camera.distortion.is_identity() && chart_.scale == 1;
    const int edge = block_texels(chart_, step);
    for (int y = box.y0; y < box.y1; y += edge) {
      poll_();
      for (int x = box.x0; x < box.x1; x += edge) {
        const CellBox block{x, y, std::min(x + edge, box.x1), std::min(y + edge, box.y1)};
        if (!any_wanted(block)) continue;
        gather_strip(strip_, block, near_);
        if (coarse)
          average_block(block, limits);
        else if (copied)
          copy_block(block);
        else
          sample_block(block);
      }
    }
  }

 private:
  bool wanted(int x, int y) const { return is_baked(raster_.reach[raster_.at(x, y)], build_.options.padding); }

  bool any_wanted(const CellBox& block) const {
    for (int y = block.y0; y < block.y1; ++y)
      for (int x = block.x0; x < block.x1; ++x)
        if (wanted(x, y)) return true;
    return false;
  }

  /// Bakes the texels of a block; sample(x, y, at) gives their colour, or nullopt outside the photo. Exposure corrects
  /// it as at the frame position `at`, the texel's centre unless `sample` changes it.
  template <typename Sample>
  void bake_block(const CellBox& block, const Sample& sample) {
    for (int y = block.y0; y < block.y1; ++y) {
      const std::array<Color, kStripRow> strip = strip_offsets(near_, block.x0 + 0.5, y + 0.5);
      for (int x = block.x0; x < block.x1; ++x) {
        if (!wanted(x, y)) continue;
        PixelPoint at = chart_.frame_position(x + 0.5, y + 0.5);
        if (const std::optional<Color> color = sample(x, y, at))
          put(x, y, *color, at, strip[static_cast<std::size_t>(x - block.x0)]);
      }
    }
  }

  void put(int x, int y, Color color, const PixelPoint& at, const Color& strip_offset) {
    const std::size_t i = raster_.at(x, y);
    const ColorCorrection& correction = build_.correction;
    if (!correction.identity()) {
      const std::uint32_t owner = raster_.owner[i];
      color = correction.expose(color, photo_.id, at) +
              correction.face_offset(owner, build_.set.corners[owner], x + 0.5, y + 0.5) + strip_offset;
    }
    const auto texel = place_.texel(x, y);
    page_.put(texel.x, texel.y, color, state_of(raster_.reach[i]));
  }

  /// Texels that are pixels of the photo.
  void copy_block(const CellBox& block) {
    const int shift_x = static_cast<int>(chart_.origin_x), shift_y = static_cast<int>(chart_.origin_y);
    bake_block(block, [&](int x, int y, PixelPoint&) -> std::optional<Color> {
      const int px = shift_x + x, py = shift_y + y;
      if (px < 0 || py < 0 || px >= photo_.image.width || py >= photo_.image.height) return std::nullopt;
      return load(photo_.image.at(px, py));
    });
  }

  void sample_block(const CellBox& block) {
    const PixelPoint low = chart_.frame_position(block.x0, block.y0);
    const PixelPoint high = chart_.frame_position(block.x1, block.y1);
    const PhotoPositions positions(photo_.view.camera, low.x, low.y, high.x, high.y);
    bake_block(block, [&](int x, int y, PixelPoint&) { return resample(positions, x, y); });
  }

  void average_block(const CellBox& block, const FrameBox& limits) {
    bake_block(block, [&](int x, int y, PixelPoint& at) {
      const FrameBox r = clipped_texel(chart_, x, y, limits);
      at = {(r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2};
      return mean(r);
    });
  }

  /// True in the photo, and in the half pixel around it that a bilinear lookup on its border reads.
  bool in_photo(const PhotoPoint& q) const {
    return q.x >= -0.5 && q.y >= -0.5 && q.x <= photo_.image.width + 0.5 && q.y <= photo_.image.height + 0.5;
  }

  /// Mean over the part of a rectangle that lies in the photo, with a sample per pixel. Lens models bend too much over
  /// a texel of many pixels to be interpolated, and so many samples need not be sharp. nullopt outside the photo.
  std::optional<Color> mean(const FrameBox& r) const {
    const auto samples = [](double length) { return std::max(1, static_cast<int>(std::ceil(length))); };
    const int columns = samples(r.x1 - r.x0), rows = samples(r.y1 - r.y0);
    std::array<double, 3> sum{};  // of up to all pixels of a photo: more than floats add without loss
    std::size_t count = 0;
    for (int j = 0; j < rows; ++j) {
      poll_();
      for (int i = 0; i < columns; ++i) {
        const PixelPoint p{r.x0 + (i + 0.5) / columns * (r.x1 - r.x0), r.y0 + (j + 0.5) / rows * (r.y1 - r.y0)};
        const auto q = photo_from_pixel(photo_.view.camera, p);
        if (!q || !in_photo(*q)) continue;
        const Color color = sample_bilinear(photo_.image, q->x, q->y);
        sum[0] += double{color.r};
        sum[1] += double{color.g};
        sum[2] += double{color.b};
        ++count;
      }
    }
    if (!count) return std::nullopt;
    const auto share = [&](double s) { return static_cast<float>(s / static_cast<double>(count)); };
    return Color{share(sum[0]), share(sum[1]), share(sum[2])};
  }

  /// One bicubic sample where texels are as fine as pixels, the mean over the texel's square where they are coarser.
  /// nullopt outside the photo.
  std::optional<Color> resample(const PhotoPositions& positions, int x, int y) const {
    const int taps = chart_.scale >= 1 ? 1 : static_cast<int>(std::ceil(1 / chart_.scale));
    ColorMean mean;
    for (int j = 0; j < taps; ++j) {
      for (int i = 0; i < taps; ++i) {
        const PixelPoint p = chart_.frame_position(x + (i + 0.5) / taps, y + (j + 0.5) / taps);
        const auto q = positions.at(p.x, p.y);
        if (q && in_photo(*q)) mean.add(sample_bicubic(photo_.image, q->x, q->y));
      }
    }
    return mean.mean();
  }

  AtlasBuild& build_;
  const ViewPhoto& photo_;
  const Chart& chart_;
  const ChartPlace& place_;
  Page& page_;
  const ChartStrip* strip_;
  Poll& poll_;
  ChartRaster raster_;             ///< of the band
  std::vector<StripSample> near_;  ///< those that matter to the block being baked
};

/// What a view's photo is needed for: a band of a plain chart, or a partial chart.
struct PhotoUse {
  std::uint32_t chart = 0;
  int band = 0;
  PartialChart* partial = nullptr;
};

using ViewWork = std::vector<PhotoUse>;

}  // namespace

void bake_photos(AtlasBuild& build, std::span<PartialChart> partial, const Progress& progress) {
  const ChartSet& set = build.set;
  std::vector<FaceBands> bands(set.charts.size());  // of plain charts
  tbb::parallel_for(std::size_t{0}, bands.size(), [&](std::size_t c) {
    if (set.charts[c].kind == ChartKind::plain) bands[c] = face_bands(set.charts[c], set.corners);
  });
  std::vector<ViewWork> work(build.input.scene.views.size());
  for (std::uint32_t c = 0; c < bands.size(); ++c)
    for (std::size_t b = 0; b < bands[c].groups(); ++b)
      work[index(set.charts[c].view)].push_back({c, static_cast<int>(b)});
  for (PartialChart& part : partial)
    for (const auto view : part.views) work[view].push_back({part.chart, 0, &part});
  const std::size_t views = work.size() - static_cast<std::size_t>(std::ranges::count(
                                              work, true, [](const ViewWork& mine) { return mine.empty(); }));
  std::size_t done = 0;
  each_photo(build.input, work, [&](const ViewPhoto& photo, const ViewWork& mine) {
    const int step = lattice_step(photo.view.camera);
    Poll poll(progress, done, views);
    tbb::parallel_for(std::size_t{0}, mine.size(), [&](std::size_t i) {
      poll();
      const auto& [chart, band, part] = mine[i];
      if (part)
        take_view(*part, build, photo);
      else
        BandBaker(build, photo, chart, poll).bake(band, bands[chart][static_cast<std::size_t>(band)], step);
    });
    if (progress) progress(++done, views);
  });
}

}  // namespace gpvc::atlas
