#include "atlas/baking/bake.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "atlas/baking/each_photo.h"
#include "atlas/baking/partial_bake.h"
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

PixelPoint texel_centre(const Chart& chart, int x, int y) { return chart.frame_position(x + 0.5, y + 0.5); }

/// A rectangle of a view's frame.
struct FrameRectangle {
  double x0, y0, x1, y1;
};

/// The part of the frame that coarse texels may read: the faces' bounding box and a border. So a chart's texels read
/// every pixel a few times at most, however coarse they are, and a texel larger than its chart has the chart's colour
/// rather than that of the whole photo.
FrameRectangle readable(const Chart& chart, std::span<const std::uint32_t> faces,
                        std::span<const TexelTriangle> corners) {
  FrameRectangle r{HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (const auto face : faces) {
    for (const TexelPoint& corner : corners[face]) {
      const PixelPoint p = chart.frame_position(corner.x, corner.y);
      r = {std::min(r.x0, p.x), std::min(r.y0, p.y), std::max(r.x1, p.x), std::max(r.y1, p.y)};
    }
  }
  // Texels reach two of their edges beyond the bounds, one of them for the ring. Up to kWholeTexelPx all of that is
  // read; beyond it less, because the share of a small chart in its texel falls.
  const double border = 2 * kWholeTexelPx * kWholeTexelPx * chart.scale;
  return {r.x0 - border, r.y0 - border, r.x1 + border, r.y1 + border};
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

FrameRectangle clipped_texel(const Chart& chart, int x, int y, const FrameRectangle& limits) {
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

/// A colour, and the frame position at which exposure corrects it.
struct FrameSample {
  Color color;
  PixelPoint at;
};

/// Rows of a plain chart on their way to its page.
struct Band {
  std::uint32_t chart;
  std::span<const std::uint32_t> faces;
  ChartRaster raster;
};

class BandBaker {
 public:
  /// \param step see lattice_step
  BandBaker(AtlasBuild& build, const ViewPhoto& photo, int step, const Band& band, Poll& poll)
      : build_(build),
        view_(photo.view),
        image_(photo.image),
        view_id_(photo.id),
        step_(step),
        band_(band),
        chart_(build.set.charts[band.chart]),
        page_(build.page_of(band.chart)),
        poll_(poll) {}

  void bake() {
    const CellBox& box = band_.raster.box;
    const bool coarse = is_coarse(chart_);
    const FrameRectangle limits = coarse ? readable(chart_, band_.faces, build_.set.corners) : FrameRectangle{};
    const bool copied = view_.camera.distortion.is_identity() && chart_.scale == 1;
    const int edge = block_texels(chart_, step_);
    for (int y = box.y0; y < box.y1; y += edge) {
      poll_();
      for (int x = box.x0; x < box.x1; x += edge) {
        const CellBox block{x, y, std::min(x + edge, box.x1), std::min(y + edge, box.y1)};
        if (!any_wanted(block)) continue;
        near_.clear();
        if (const ChartStrip* strip = build_.correction.strip(band_.chart)) gather_strip(*strip, block, near_);
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
  bool wanted(int x, int y) const {
    return is_baked(band_.raster.reach[band_.raster.at(x, y)], build_.options.padding);
  }

  bool any_wanted(const CellBox& block) const {
    for (int y = block.y0; y < block.y1; ++y)
      for (int x = block.x0; x < block.x1; ++x)
        if (wanted(x, y)) return true;
    return false;
  }

  /// Bakes the texels of a block; sample(x, y) gives their FrameSample, or nullopt outside the photo.
  template <typename Sample>
  void bake_block(const CellBox& block, const Sample& sample) {
    for (int y = block.y0; y < block.y1; ++y) {
      std::array<Color, kStripRow> strip{};
      if (!near_.empty()) strip = strip_offsets(near_, block.x0 + 0.5, y + 0.5);
      for (int x = block.x0; x < block.x1; ++x) {
        if (!wanted(x, y)) continue;
        if (const std::optional<FrameSample> from = sample(x, y))
          put(x, y, *from, strip[static_cast<std::size_t>(x - block.x0)]);
      }
    }
  }

  void put(int x, int y, const FrameSample& from, const Color& strip_offset) {
    const std::size_t i = band_.raster.at(x, y);
    const ColorCorrection& correction = build_.correction;
    Color color = from.color;
    if (!correction.identity()) {
      const std::uint32_t owner = band_.raster.owner[i];
      color = correction.expose(color, view_id_, from.at) +
              correction.face_offset(owner, build_.set.corners[owner], x + 0.5, y + 0.5) + strip_offset;
    }
    const auto texel = build_.places[band_.chart].texel(x, y);
    page_.put(texel.x, texel.y, color, state_of(band_.raster.reach[i]));
  }

  /// Texels that are pixels of the photo.
  void copy_block(const CellBox& block) {
    const int shift_x = static_cast<int>(chart_.origin_x), shift_y = static_cast<int>(chart_.origin_y);
    bake_block(block, [&](int x, int y) -> std::optional<FrameSample> {
      const int px = shift_x + x, py = shift_y + y;
      if (px < 0 || py < 0 || px >= image_.width || py >= image_.height) return std::nullopt;
      return FrameSample{load(image_.at(px, py)), texel_centre(chart_, x, y)};
    });
  }

  void sample_block(const CellBox& block) {
    const PixelPoint low = chart_.frame_position(block.x0, block.y0);
    const PixelPoint high = chart_.frame_position(block.x1, block.y1);
    const PhotoPositions positions(view_.camera, low.x, low.y, high.x, high.y);
    bake_block(block, [&](int x, int y) -> std::optional<FrameSample> {
      const auto color = resample(positions, x, y);
      if (!color) return std::nullopt;
      return FrameSample{*color, texel_centre(chart_, x, y)};
    });
  }

  void average_block(const CellBox& block, const FrameRectangle& limits) {
    bake_block(block, [&](int x, int y) -> std::optional<FrameSample> {
      const FrameRectangle r = clipped_texel(chart_, x, y, limits);
      const auto color = mean(r);
      if (!color) return std::nullopt;
      return FrameSample{*color, {(r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2}};
    });
  }

  /// True in the photo, and in the half pixel around it that a bilinear lookup on its border reads.
  bool in_photo(const PhotoPoint& q) const {
    return q.x >= -0.5 && q.y >= -0.5 && q.x <= image_.width + 0.5 && q.y <= image_.height + 0.5;
  }

  /// Mean over the part of a rectangle that lies in the photo, with a sample per pixel. Lens models bend too much over
  /// a texel of many pixels to be interpolated, and so many samples need not be sharp. nullopt outside the photo.
  std::optional<Color> mean(const FrameRectangle& r) const {
    const auto samples = [](double length) { return std::max(1, static_cast<int>(std::ceil(length))); };
    const int columns = samples(r.x1 - r.x0), rows = samples(r.y1 - r.y0);
    std::array<double, 3> sum{};  // of up to all pixels of a photo: more than floats add without loss
    std::size_t count = 0;
    for (int j = 0; j < rows; ++j) {
      poll_();
      for (int i = 0; i < columns; ++i) {
        const PixelPoint p{r.x0 + (i + 0.5) / columns * (r.x1 - r.x0), r.y0 + (j + 0.5) / rows * (r.y1 - r.y0)};
        const auto q = photo_from_pixel(view_.camera, p);
        if (!q || !in_photo(*q)) continue;
        const Color color = sample_bilinear(image_, q->x, q->y);
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
    Color sum;
    int count = 0;
    for (int j = 0; j < taps; ++j) {
      for (int i = 0; i < taps; ++i) {
        const PixelPoint p = chart_.frame_position(x + (i + 0.5) / taps, y + (j + 0.5) / taps);
        const auto q = positions.at(p.x, p.y);
        if (!q || !in_photo(*q)) continue;
        sum = sum + sample_bicubic(image_, q->x, q->y);
        ++count;
      }
    }
    if (!count) return std::nullopt;
    return (1.0f / static_cast<float>(count)) * sum;
  }

  AtlasBuild& build_;
  const View& view_;
  const Image& image_;
  ViewId view_id_;
  int step_;
  const Band& band_;
  const Chart& chart_;
  Page& page_;
  Poll& poll_;
  std::vector<StripSample> near_;  ///< those that matter to the block being baked
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

std::vector<ViewWork> gather_work(const AtlasBuild& build, std::span<const FaceBands> bands,
                                  std::span<const PartialChart> partial) {
  std::vector<ViewWork> work(build.input.scene.views.size());
  for (std::uint32_t c = 0; c < bands.size(); ++c)
    for (std::size_t b = 0; b < bands[c].groups(); ++b)
      work[index(build.set.charts[c].view)].bands.push_back({c, static_cast<int>(b)});
  for (std::uint32_t p = 0; p < partial.size(); ++p)
    for (const auto view : partial[p].views) work[view].partial.push_back(p);
  return work;
}

}  // namespace

void bake_photos(AtlasBuild& build, std::span<PartialChart> partial, const Progress& progress) {
  const ChartSet& set = build.set;
  std::vector<FaceBands> bands(set.charts.size());  // of plain charts
  tbb::parallel_for(std::size_t{0}, bands.size(), [&](std::size_t c) {
    if (set.charts[c].kind == ChartKind::plain) bands[c] = face_bands(set.charts[c], set.corners);
  });
  const std::vector<ViewWork> work = gather_work(build, bands, partial);
  std::vector<std::uint32_t> views;
  for (std::uint32_t v = 0; v < work.size(); ++v)
    if (!work[v].empty()) views.push_back(v);

  std::size_t done = 0;
  each_photo(build.input, views, [&](const ViewPhoto& photo) {
    const ViewWork& mine = work[index(photo.id)];
    const int step = lattice_step(photo.view.camera);
    Poll poll(progress, done, views.size());
    tbb::parallel_for(std::size_t{0}, mine.bands.size() + mine.partial.size(), [&](std::size_t i) {
      poll();
      if (i >= mine.bands.size()) return take_view(partial[mine.partial[i - mine.bands.size()]], build, photo);
      const auto [c, b] = mine.bands[i];
      const auto faces = bands[c][static_cast<std::size_t>(b)];
      const Band band{c, faces, rasterize(faces, set.corners, band_box(set.charts[c], b))};
      BandBaker(build, photo, step, band, poll).bake();
    });
    if (progress) progress(++done, views.size());
  });
}

}  // namespace gpvc::atlas
