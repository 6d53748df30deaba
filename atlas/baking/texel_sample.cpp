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

/// Samples along an edge of so many pixels; 64 at most. A texel as fine as the photo takes one, though rounding puts its edge
/// above a pixel.
int samples_along(double edge_px) {
  constexpr double kMost = 64;
  return static_cast<int>(std::ceil(std::clamp(edge_px - 0.01, 1.0, kMost)));
}

/// \param given the place is given: edges may differ
Footprint footprint(const TexelSource& source, bool given, int x, int y) {
  const auto a = source.frame_from_texel(x, y), b = source.frame_from_texel(x + 1, y),
             c = source.frame_from_texel(x, y + 1);
  if (!a || !b || !c) return {1, 1, given};
  const auto edge = [&](const PixelPoint& p) {
    return std::sqrt((p.x - a->x) * (p.x - a->x) + (p.y - a->y) * (p.y - a->y));
  };
  const double across = edge(*b), down = edge(*c), longer = std::max(across, down);
  if (!given) return {samples_along(longer), samples_along(longer)};
  return {samples_along(across), samples_along(down), longer > kWholeTexelPx};
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

const InnerRow& TexelSampler::inner(int row, int rows) {
  if (inner_.size() != static_cast<std::size_t>(rows)) {
    inner_.clear();
    for (int j = 0; j < rows; ++j) inner_.push_back(inner_row(*source_, y_ + (j + 0.5) / rows));
  }
  return inner_[static_cast<std::size_t>(row)];
}

std::optional<ExposedTexel> TexelSampler::sample(int x, std::vector<Color>& samples) {
  const AtlasBuild& build = build_;
  const ViewPhoto& photo = photo_;
  const TexelSource& source = *source_;
  const int y = y_;
  const bool given = build.input.layout != nullptr;
  const Footprint f = footprint(source, given, x, y);
  const bool several = f.across > 1 || f.down > 1;
  const Overshoot overshoot =
      build.painting.bands != nullptr && build.painting.are_limited() ? Overshoot::limited : Overshoot::kept;
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
        samples[layer - 1] = samples[layer - 1] + sample_bicubic(photo.layer(layer), q->x, q->y, overshoot);
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
