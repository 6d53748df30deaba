// Fills pages with colour from the photos, view by view.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "atlas/baking/baking.h"
#include "atlas/baking/poll.h"
#include "atlas/sampling/sampling.h"

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
        gain_ = build_.correction.gain(photo_.id,
                                       chart_.frame_position((block.x0 + block.x1) / 2.0, (block.y0 + block.y1) / 2.0));
        local_gain_ = local_gain(block);
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
  static_assert(PhotoPatch::kRow == kStripRow);
  /// Colours of a row of texels of a block in a layer, exposed in the first and sampled in the others, and whether they are known.
  struct Row {
    std::array<Color, kStripRow> color{}, strip{};
    std::array<bool, kStripRow> known{};
  };

  bool wanted(int x, int y) const { return is_baked(raster_.reach[raster_.at(x, y)], build_.options.padding); }

  bool any_wanted(const CellBox& block) const {
    for (int y = block.y0; y < block.y1; ++y)
      for (int x = block.x0; x < block.x1; ++x)
        if (wanted(x, y)) return true;
    return false;
  }

  /// Bakes the texels of a block; fill(layer, y, row) gives a row's colours.
  template <typename Fill>
  void bake_block(const CellBox& block, const Fill& fill) {
    for (int y = block.y0; y < block.y1; ++y) {
      Row row;
      fill(0, y, row);
      if (!near_.empty()) row.strip = strip_offsets(near_, block.x0 + 0.5, y + 0.5);
      put(block, y, row);
      for (std::size_t layer = 1; layer < build_.painting.layers(); ++layer) {
        row.color = {};
        fill(layer, y, row);
        put_samples(layer, block, y, row);
      }
    }
  }

  /// As bake_block; sample(layer, x, y) gives the colour of a texel, or nullopt outside the photo.
  template <typename Sample>
  void bake_texels(const CellBox& block, const Sample& sample) {
    bake_block(block, [&](std::size_t layer, int y, Row& row) {
      for (int x = block.x0; x < block.x1; ++x) {
        if (!wanted(x, y)) continue;
        const auto i = static_cast<std::size_t>(x - block.x0);
        const std::optional<Color> color = sample(layer, x, y);
        row.known[i] = color.has_value();
        if (color) row.color[i] = *color;
      }
    });
  }

  void put(const CellBox& block, int y, const Row& row) {
    const auto texel = place_.texel(block.x0, y), next = place_.texel(block.x0 + 1, y);
    const std::ptrdiff_t stride = next.x - texel.x + std::ptrdiff_t{next.y - texel.y} * page_.image.width;
    auto to = static_cast<std::ptrdiff_t>(page_.at(texel.x, texel.y));
    std::size_t from = raster_.at(block.x0, y);
    for (int x = block.x0; x < block.x1; ++x, to += stride, ++from) {
      const auto i = static_cast<std::size_t>(x - block.x0);
      const TexelReach reach = raster_.reach[from];
      if (!row.known[i] || !is_baked(reach, build_.options.padding)) continue;
      store(page_.image.pixels.data() + 3 * to,
            corrected(row.color[i], added(raster_.owner[from], reach, x + 0.5, y + 0.5, row.strip[i]), gain_));
      page_.state[static_cast<std::size_t>(to)] = state_of(reach);
    }
  }

  void put_samples(std::size_t number, const CellBox& block, int y, const Row& row) {
    const PageLayer layer = page_.layer(number);
    std::size_t from = raster_.at(block.x0, y);
    for (int x = block.x0; x < block.x1; ++x, ++from) {
      const auto i = static_cast<std::size_t>(x - block.x0);
      const TexelReach reach = raster_.reach[from];
      if (!row.known[i] || !is_baked(reach, build_.options.padding)) continue;
      Color gain{1, 1, 1}, added;
      const PixelPoint frame = chart_.frame_position(x + 0.5, y + 0.5);
      if (build_.painting.are_colors()) {
        added = this->added(raster_.owner[from], reach, x + 0.5, y + 0.5, row.strip[i]);
        if (local_gain_) gain = local_gain_->at(frame);
      }
      const auto texel = place_.texel(x, y);
      layer.put(page_.at(texel.x, texel.y),
                build_.painting.painted(number, row.color[i], photo_.id, frame, gain, added));
    }
  }

  Color added(std::uint32_t face, TexelReach reach, double x, double y, const Color& strip) {
    const ColorCorrection& correction = build_.correction;
    if (correction.nodes.empty()) return strip;
    const TexelTriangle& corners = build_.set.corners[face];
    if (reach != TexelReach::centre) return correction.added(face, corners, x, y, strip);
    if (face != face_) {
      face_ = face;
      plane_ = correction.offset_plane(face, corners);
      limits_strip_ = correction.limits_strip(face);
      if (limits_strip_) strip_plane_ = correction.strip_plane(face, corners);
    }
    return plane_.at(x, y) + (limits_strip_ ? strip_plane_.at(x, y) * strip : strip);
  }

  /// Exposure near the middle of a block.
  std::optional<LocalGain> local_gain(const CellBox& block) const {
    const ColorCorrection& correction = build_.correction;
    if (correction.exposure.empty()) return std::nullopt;
    const PixelPoint middle = chart_.frame_position((block.x0 + block.x1) / 2.0, (block.y0 + block.y1) / 2.0);
    return LocalGain(correction.exposure[index(photo_.id)], middle);
  }

  /// The exposed colour in the first layer, the sampled one in others.
  Color exposed(std::size_t layer, const Color& color, int x, int y) const {
    return layer == 0 && local_gain_ ? local_gain_->at(chart_.frame_position(x + 0.5, y + 0.5)) * color : color;
  }

  Overshoot overshoot() const { return build_.painting.are_limited() ? Overshoot::limited : Overshoot::kept; }

  /// Texels that are pixels of the photo.
  void copy_block(const CellBox& block) {
    const int shift_x = static_cast<int>(chart_.origin_x), shift_y = static_cast<int>(chart_.origin_y);
    bake_texels(block, [&](std::size_t layer, int x, int y) -> std::optional<Color> {
      const int px = shift_x + x, py = shift_y + y;
      if (px < 0 || py < 0 || px >= photo_.image.width || py >= photo_.image.height) return std::nullopt;
      return exposed(layer, layer == 0 ? load(photo_.image.at(px, py)) : photo_.layer(layer).at(px, py), x, y);
    });
  }

  void sample_block(const CellBox& block) {
    const PixelPoint low = chart_.frame_position(block.x0, block.y0);
    const PixelPoint high = chart_.frame_position(block.x1, block.y1);
    const PhotoPositions positions(photo_.view.camera, low.x, low.y, high.x, high.y);
    const auto& corners = positions.corners();
    if (positions.interpolated() && std::ranges::all_of(corners, [&](const auto& q) { return in_photo(q); }))
      return sample_inner_block(block, corners);
    bake_texels(block, [&](std::size_t layer, int x, int y) -> std::optional<Color> {
      const std::optional<Color> color = resample(layer, positions, x, y);
      return color ? std::optional(exposed(layer, *color, x, y)) : std::nullopt;
    });
  }

  /// A block that lies in the photo, whose texels' positions are interpolated between its corners.
  void sample_inner_block(const CellBox& block, const std::array<PhotoPoint, 4>& corners) {
    FrameBox bounds;
    for (const PhotoPoint& q : corners) bounds.add(q.x, q.y);
    patches_.resize(build_.painting.layers());
    patches_[0].load(photo_.image, {bounds.x0, bounds.y0}, {bounds.x1, bounds.y1});
    for (std::size_t layer = 1; layer < patches_.size(); ++layer)
      patches_[layer].load(photo_.layer(layer), {bounds.x0, bounds.y0}, {bounds.x1, bounds.y1});
    const int width = block.x1 - block.x0, height = block.y1 - block.y0, n = taps();
    const auto between = [](const PhotoPoint& a, const PhotoPoint& b, double t) {
      return PhotoPoint{a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t};
    };
    bake_block(block, [&](std::size_t layer, int y, Row& row) {
      const Overshoot limit = layer == 0 ? Overshoot::kept : overshoot();
      for (int j = 0; j < n; ++j) {
        const double v = (y - block.y0 + (j + 0.5) / n) / height;
        const PhotoPoint left = between(corners[0], corners[2], v), right = between(corners[1], corners[3], v);
        const PhotoPoint step{(right.x - left.x) / width, (right.y - left.y) / width};
        for (int i = 0; i < n; ++i)
          patches_[layer].add_row({left.x + (i + 0.5) / n * step.x, left.y + (i + 0.5) / n * step.y}, step, row.color,
                                  limit);
      }
      const float share = 1 / static_cast<float>(n * n);
      for (int x = block.x0; x < block.x1; ++x) {
        const auto i = static_cast<std::size_t>(x - block.x0);
        row.color[i] = exposed(layer, share * row.color[i], x, y);
        row.known[i] = true;
      }
    });
  }

  void average_block(const CellBox& block, const FrameBox& limits) {
    bake_texels(block, [&](std::size_t layer, int x, int y) -> std::optional<Color> {
      const FrameBox r = clipped_texel(chart_, x, y, limits);
      const std::optional<Color> color = mean(layer, r);
      if (!color || layer > 0) return color;
      return build_.correction.gain(photo_.id, {(r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2}) * *color;
    });
  }

  /// True in the photo, and in the half pixel around it that a bilinear lookup on its border reads.
  bool in_photo(const PhotoPoint& q) const {
    return q.x >= -0.5 && q.y >= -0.5 && q.x <= photo_.image.width + 0.5 && q.y <= photo_.image.height + 0.5;
  }

  /// Mean over the part of a rectangle that lies in the photo, with a sample per pixel. Lens models bend too much over
  /// a texel of many pixels to be interpolated, and so many samples need not be sharp. nullopt outside the photo.
  std::optional<Color> mean(std::size_t layer, const FrameBox& r) const {
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
        const Color color =
            layer == 0 ? sample_bilinear(photo_.image, q->x, q->y) : sample_bilinear(photo_.layer(layer), q->x, q->y);
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

  /// Samples along each edge of a texel: one where texels are as fine as pixels, else the mean over the texel's square
  /// is taken.
  int taps() const { return chart_.scale >= 1 ? 1 : static_cast<int>(std::ceil(1 / chart_.scale)); }

  /// The mean of the bicubic samples of a texel that lie in the photo; nullopt if none does.
  std::optional<Color> resample(std::size_t layer, const PhotoPositions& positions, int x, int y) const {
    const int n = taps();
    ColorMean mean;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const PixelPoint p = chart_.frame_position(x + (i + 0.5) / n, y + (j + 0.5) / n);
        const auto q = positions.at(p.x, p.y);
        if (!q || !in_photo(*q)) continue;
        mean.add(layer == 0 ? sample_bicubic(photo_.image, q->x, q->y)
                            : sample_bicubic(photo_.layer(layer), q->x, q->y, overshoot()));
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
  ChartRaster raster_;                   ///< of the band
  std::vector<StripSample> near_;        ///< those that matter to the block being baked
  Color gain_{1, 1, 1};                  ///< in the middle of the block
  std::optional<LocalGain> local_gain_;  ///< around it
  std::vector<PhotoPatch> patches_;      ///< under the block, per layer
  std::uint32_t face_ = kNoOwner;        ///< the face of the planes
  OffsetPlane plane_, strip_plane_;
  bool limits_strip_ = false;  ///< whether strip_plane_ is the face's
};

/// What a view's photo is needed for: a band of a plain chart, or a partial chart.
struct PhotoUse {
  std::uint32_t chart = 0;
  int band = 0;
  PartialChart* partial = nullptr;
};

}  // namespace

std::vector<std::uint32_t> plain_charts_on(const AtlasBuild& build, const PageRange& pages) {
  std::vector<std::uint32_t> charts;
  for (std::uint32_t c = 0; c < build.set.placed; ++c)
    if (build.set.charts[c].kind == ChartKind::plain && pages.has(build.places[c].page)) charts.push_back(c);
  return charts;
}

void bake_photos(AtlasBuild& build, const PageRange& plain, std::span<PartialChart> partial, PhotoOrder order,
                 const Progress& progress) {
  const ChartSet& set = build.set;
  const std::vector<std::uint32_t> charts = plain_charts_on(build, plain);
  std::vector<FaceBands> bands(set.charts.size());  // of these
  tbb::parallel_for(std::size_t{0}, charts.size(),
                    [&](std::size_t i) { bands[charts[i]] = face_bands(set.charts[charts[i]], set.corners); });
  std::vector<std::vector<PhotoUse>> work(build.input.scene.views.size());
  for (const std::uint32_t c : charts)
    for (std::size_t b = 0; b < bands[c].groups(); ++b)
      work[index(set.charts[c].view)].push_back({c, static_cast<int>(b)});
  for (PartialChart& part : partial)
    for (const auto view : part.views) work[view].push_back({part.chart, 0, &part});
  const std::size_t views = count_wanted(work);
  std::size_t done = 0;
  struct Fetched {
    std::shared_ptr<const Image> image;
    std::shared_ptr<const Samples> samples;
  };
  const bool has_bands = build.painting.bands != nullptr;
  const auto fetch = [&](ViewId id) {
    Fetched fetched;
    if (has_bands) fetched.samples = build.input.photos.samples(id);  // with the picture from one decoding
    fetched.image = build.input.photos.photo(id);
    return fetched;
  };
  each_fetched(work, order, fetch, [&](ViewId id, Fetched& fetched, const std::vector<PhotoUse>& mine) {
    const ViewPhoto photo{id, build.input.scene.views[index(id)], *fetched.image, fetched.samples.get()};
    const int step = lattice_step(photo.view.camera);
    Poll poll(progress, done, views);
    tbb::parallel_for(std::size_t{0}, mine.size(), [&](std::size_t i) {
      const PhotoUse& use = mine[i];
      poll();
      const auto faces = [&] { return bands[use.chart][static_cast<std::size_t>(use.band)]; };
      if (use.partial)
        take_view(*use.partial, build, photo);
      else if (set.charts[use.chart].given)
        bake_given_band(build, photo, use.chart, use.band, faces(), poll);
      else
        BandBaker(build, photo, use.chart, poll).bake(use.band, faces(), step);
    });
    if (progress) progress(++done, views);
  });
}

}  // namespace gpvc::atlas
