#include "atlas/baking/texel_sample.h"

#include <algorithm>
#include <cmath>

#include "io/vector.h"

namespace gpvc::atlas {
namespace {

/// Up to so many pixels all of a texel is looked at, as where charts are projections (bake.cpp).
constexpr double kWholeTexelPx = 16;

/// Samples along the edges of a texel.
struct Footprint {
  int across = 1, down = 1;
  bool is_large = false;  ///< it takes more than kWholeTexelPx somewhere
};

/// Edges up to so many pixels take one sample: photos show little that is finer, and the mean of four would blur what they show.
constexpr double kSinglePx = 1.5;

/// Samples along an edge of so many pixels, one for each; 64 at most.
int samples_along(double edge_px) {
  constexpr double kMost = 64;
  return static_cast<int>(std::lround(std::clamp(edge_px, 1.0, kMost)));
}

double length(const PixelPoint& p) { return std::sqrt(p.x * p.x + p.y * p.y); }

/// \param given the place is given: edges may differ
Footprint footprint(const TexelSource& source, bool given, int x, int y) {
  const auto a = source.frame_from_texel(x, y), b = source.frame_from_texel(x + 1, y),
             c = source.frame_from_texel(x, y + 1);
  if (!a || !b || !c) return {1, 1, given};
  const auto edge = [&](const PixelPoint& p) { return length({p.x - a->x, p.y - a->y}); };
  const double across = edge(*b), down = edge(*c), longer = std::max(across, down);
  if (!given) return {samples_along(longer), samples_along(longer)};
  return {samples_along(across), samples_along(down), longer > kWholeTexelPx};
}

/// True if texels first .. first + count - 1 of a row certainly have edges of less than kSinglePx.
///
/// With w = m6 x + m7 y + m8, an edge along x is c / (w(x, y) w(x + 1, y)), where the vector c does not depend on x, and one along y
/// is d / (w(x, y) w(x, y + 1)), where d is linear in x: both are longest for a d at an end and for the least w, at a corner.
bool takes_one_sample(const FrameFromTexel& frame_from_texel, int y, int first, int count) {
  const auto& m = frame_from_texel.matrix;
  const double x0 = first, x1 = first + count, y0 = y, y1 = y + 1.0;
  const auto w = [&](double x, double v) { return m[6] * x + m[7] * v + m[8]; };
  const double least = std::min({w(x0, y0), w(x1, y0), w(x0, y1), w(x1, y1)});
  if (!(least > 0)) return false;
  const auto across = [&](std::size_t row) {
    return m[row] * (m[7] * y0 + m[8]) - m[6] * (m[row + 1] * y0 + m[row + 2]);
  };
  const auto down = [&](std::size_t row, double x) {
    return m[row + 1] * (m[6] * x + m[8]) - m[7] * (m[row] * x + m[row + 2]);
  };
  const double longest = std::max(
      {length({across(0), across(3)}), length({down(0, x0), down(3, x0)}), length({down(0, x1), down(3, x1)})});
  return longest < kSinglePx * least * least;
}

/// The frame position of a place in texels, no further than kWholeTexelPx from what the view shows of the face: beyond a thin face,
/// or one far smaller than a texel, its plane leads anywhere.
std::optional<PixelPoint> position_close_to_face(const AtlasBuild& build, const View& view, const TexelSource& source,
                                                 double x, double y) {
  const std::array<double, 3> share = shares_at(build.set.corners[source.face], x, y);
  WorldPoint on_face;
  for (std::size_t i = 0; i < 3; ++i)
    on_face = on_face + build.input.mesh.positions[build.input.mesh.faces[source.face][i]] * share[i];
  const CameraPoint c = camera_from_world(view.pose, on_face);
  if (!(c.z > 0)) return std::nullopt;
  const PixelPoint near = pixel_from_camera(view.camera, c);
  const auto far = source.frame_from_texel(x, y);
  if (!far) return near;
  const double dx = far->x - near.x, dy = far->y - near.y, distance = std::sqrt(dx * dx + dy * dy);
  if (distance <= kWholeTexelPx) return far;
  const double part = kWholeTexelPx / distance;
  return std::isfinite(distance) ? PixelPoint{near.x + part * dx, near.y + part * dy} : near;
}

}  // namespace

void TexelSampler::begin(const TexelSource& source, int y, int first, int count) {
  source_ = &source;
  y_ = y;
  inner_.clear();
  gain_.reset();
  takes_one_ = takes_one_sample(source.frame_from_texel, y, first, count);
  if (!takes_one_ || build_.correction.exposure.empty()) return;
  // In front of the camera, as the corners of the row are.
  if (const auto middle = source.frame_from_texel(first + 0.5 * count, y + 0.5))
    gain_.emplace(build_.correction.exposure[index(photo_.id)], *middle);
}

const InnerRow& TexelSampler::inner(int row, int rows) {
  if (inner_.size() != static_cast<std::size_t>(rows)) {
    inner_.clear();
    for (int j = 0; j < rows; ++j) inner_.push_back(inner_row(*source_, y_ + (j + 0.5) / rows));
  }
  return inner_[static_cast<std::size_t>(row)];
}

std::optional<ExposedTexel> TexelSampler::sample(int x, std::vector<Color>& samples) {
  return takes_one_ ? one_sample(x, samples) : mean_of_samples(x, samples);
}

Overshoot TexelSampler::overshoot() const {
  return build_.painting.bands != nullptr && build_.painting.are_limited() ? Overshoot::limited : Overshoot::kept;
}

std::optional<ExposedTexel> TexelSampler::one_sample(int x, std::vector<Color>& samples) const {
  const auto p = source_->frame_from_texel(x + 0.5, y_ + 0.5);
  const auto q = p ? photo_from_pixel(photo_.view.camera, *p) : std::nullopt;
  if (!q) return std::nullopt;
  const Color gain = gain_ ? gain_->at(*p) : Color{1, 1, 1};
  for (std::size_t layer = 1; layer <= samples.size(); ++layer)
    samples[layer - 1] = sample_bicubic(photo_.layer(layer), q->x, q->y, overshoot());
  return ExposedTexel{gain * sample_bicubic(photo_.image, q->x, q->y), gain, *p};
}

std::optional<ExposedTexel> TexelSampler::mean_of_samples(int x, std::vector<Color>& samples) {
  const AtlasBuild& build = build_;
  const ViewPhoto& photo = photo_;
  const TexelSource& source = *source_;
  const int y = y_;
  const Footprint f = footprint(source, build.input.layout != nullptr, x, y);
  const bool several = f.across > 1 || f.down > 1;
  ColorMean mean, gains;
  PixelPoint frame;
  std::ranges::fill(samples, Color{});
  for (int j = 0; j < f.down; ++j) {
    for (int i = 0; i < f.across; ++i) {
      const double tx = x + (i + 0.5) / f.across, ty = y + (j + 0.5) / f.down;
      if (several && sight_at(source, build.coverage.table(), inner(j, f.down), tx, ty) == Sight::hidden) continue;
      const auto p =
          f.is_large ? position_close_to_face(build, photo.view, source, tx, ty) : source.frame_from_texel(tx, ty);
      const auto q = p ? photo_from_pixel(photo.view.camera, *p) : std::nullopt;
      if (!q) continue;
      const Color gain = build.correction.gain(photo.id, *p);
      mean.add(gain * sample_bicubic(photo.image, q->x, q->y));
      gains.add(gain);
      frame = *p;
      for (std::size_t layer = 1; layer <= samples.size(); ++layer)
        samples[layer - 1] = samples[layer - 1] + sample_bicubic(photo.layer(layer), q->x, q->y, overshoot());
    }
  }
  const std::optional<Color> color = mean.mean();
  if (!color) return std::nullopt;
  for (Color& of_layer : samples) of_layer = (1 / mean.weight) * of_layer;
  return ExposedTexel{*color, *gains.mean(), frame};
}

Color StripOffsets::at(int x, int y) {
  if (strip_ == nullptr) return {};
  const auto start = [](int i, int first) { return first + (i - first) / kStripRow * kStripRow; };
  const int x0 = start(x, box_.x0), y0 = start(y, box_.y0);
  if (x0 != x0_ || y0 != y0_)
    gather_strip(strip_, {x0, y0, std::min(x0 + kStripRow, box_.x1), std::min(y0 + kStripRow, box_.y1)}, near_);
  if (x0 != x0_ || y != row_) offsets_ = strip_offsets(near_, x0 + 0.5, y + 0.5);
  x0_ = x0;
  y0_ = y0;
  row_ = y;
  return offsets_[static_cast<std::size_t>(x - x0)];
}

}  // namespace gpvc::atlas
