#include "atlas/baking/sampling.h"

#include <Eigen/Core>
#include <algorithm>

#include "io/bilinear.h"

namespace gpvc::atlas {

namespace {

std::array<float, 4> catmull_rom(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {0.5f * (-t + 2 * t2 - t3), 0.5f * (2 - 5 * t2 + 3 * t3), 0.5f * (t + 4 * t2 - 3 * t3), 0.5f * (t3 - t2)};
}

/// The four pixels around a position along one axis, clamped to the image.
struct Taps {
  std::array<int, 4> index;
  float fraction;
};

Taps taps(double position, int size) {
  const double clamped = std::clamp(position - 0.5, 0.0, size - 1.0);
  const int base = static_cast<int>(clamped);
  Taps result{{}, static_cast<float>(clamped - base)};
  for (int i = 0; i < 4; ++i) result.index[static_cast<std::size_t>(i)] = std::clamp(base - 1 + i, 0, size - 1);
  return result;
}

}  // namespace

Color sample_bicubic(const Image& photo, double x, double y) {
  const Taps tx = taps(x, photo.width), ty = taps(y, photo.height);
  const auto wx = catmull_rom(tx.fraction), wy = catmull_rom(ty.fraction);
  Color sum;
  for (std::size_t j = 0; j < 4; ++j) {
    const std::uint8_t* line = photo.at(0, ty.index[j]);
    Color row;
    for (std::size_t i = 0; i < 4; ++i) row = row + wx[i] * load(line + 3 * tx.index[i]);
    sum = sum + wy[j] * row;
  }
  return sum;
}

Color sample_bilinear(const Image& photo, double x, double y) {
  const auto [r, g, b] = bilinear<float>(photo, x, y);
  return {r, g, b};
}

int lattice_step(const Camera& shifted) {
  constexpr int kLargest = 16;
  Camera camera = shifted;
  camera.distortion.aligned = {};
  if (camera.distortion.is_identity() || shows_pole(camera.distortion.model)) return kLargest;
  // The error of bilinear interpolation over a square of edge s is at most s^2 / 8 times the sum of the second
  // derivatives along x and y. These are measured as second differences on a grid over the frame. They grow towards the
  // corners of the frame, so they are doubled to bound what lies between the points of the grid.
  constexpr int kGrid = 24;
  constexpr double kSpan = 4;  // px
  double curvature = 0;
  for (int j = 0; j <= kGrid; ++j) {
    for (int i = 0; i <= kGrid; ++i) {
      const double x = double(i) * camera.width / kGrid, y = double(j) * camera.height / kGrid;
      const auto c = photo_from_pixel(camera, {x, y});
      double sum_x = 0, sum_y = 0;
      for (const auto& [dx, dy] : {std::pair(kSpan, 0.0), std::pair(0.0, kSpan)}) {
        const auto a = photo_from_pixel(camera, {x - dx, y - dy}), b = photo_from_pixel(camera, {x + dx, y + dy});
        if (!a || !b || !c) continue;
        sum_x += std::abs(a->x - 2 * c->x + b->x) / (kSpan * kSpan);
        sum_y += std::abs(a->y - 2 * c->y + b->y) / (kSpan * kSpan);
      }
      curvature = std::max(curvature, std::hypot(sum_x, sum_y));
    }
  }
  int step = kLargest;
  while (step > 1 && 2 * curvature * step * step / 8 > kLatticeErrorPx) step /= 2;
  return step;
}

PhotoPositions::PhotoPositions(const Camera& camera, double x0, double y0, double x1, double y1)
    : camera_(&camera),
      x0_(x0),
      y0_(y0),
      inverse_width_(1 / (x1 - x0)),
      inverse_height_(1 / (y1 - y0)),
      interpolated_(!shows_pole(camera.distortion.model)) {
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = photo_from_pixel(camera, {i % 2 ? x1 : x0, i / 2 ? y1 : y0});
    interpolated_ = interpolated_ && corner;
    corners_[i] = corner.value_or(PhotoPoint{});
  }
}

PhotoPatch::Axis::Axis(double from, double to, int size) {
  // Positions are computed in floats, whose rounding in a patch of up to a thousand pixels is below this.
  constexpr double kRounding = 1e-3;
  const double last = size - 1.0;
  const double begin = std::clamp(from - 0.5 - kRounding, 0.0, last), end = std::clamp(to - 0.5 + kRounding, 0.0, last);
  first = static_cast<int>(begin) - 1;
  count = static_cast<int>(end) + 3 - first;
  low = static_cast<float>(begin - first);
  // Rounded up to a whole number, it would read a pixel more.
  high = std::min(static_cast<float>(end - first), std::nextafter(static_cast<float>(count - 2), 0.0f));
}

PhotoPatch::Taps::Taps(const Axis& axis, double from, double step) {
  const float begin = static_cast<float>(axis.place(from)), stride = static_cast<float>(step);
  for (std::size_t i = 0; i < kRow; ++i) {
    const float place = begin + static_cast<float>(i) * stride;
    const float clamped = std::min(std::max(place, axis.low), axis.high);
    const int base = static_cast<int>(clamped);
    first[i] = base - 1;
    const auto w = catmull_rom(clamped - static_cast<float>(base));
    for (std::size_t k = 0; k < 4; ++k) weight[k][i] = w[k];
  }
}

void PhotoPatch::load(const Image& photo, const PhotoPoint& low, const PhotoPoint& high) {
  x_ = Axis(low.x, high.x, photo.width);
  y_ = Axis(low.y, high.y, photo.height);
  pixels_.resize(4 * pixel_index(0, y_.count, x_.count));
  float* to = pixels_.data();
  for (int j = 0; j < y_.count; ++j) {
    const std::uint8_t* line = photo.at(0, std::clamp(y_.first + j, 0, photo.height - 1));
    for (int i = 0; i < x_.count; ++i, to += 4) {
      const std::uint8_t* pixel = line + 3 * std::clamp(x_.first + i, 0, photo.width - 1);
      for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(pixel[c]);
    }
  }
}

void PhotoPatch::add_row(const PhotoPoint& first, const PhotoPoint& step, std::span<Color, kRow> sums) const {
  using Pixel = Eigen::Array4f;
  const Taps tx(x_, first.x, step.x), ty(y_, first.y, step.y);
  for (std::size_t i = 0; i < kRow; ++i) {
    const float* pixel = pixels_.data() + 4 * pixel_index(tx.first[i], ty.first[i], x_.count);
    Pixel sum = Pixel::Zero();
    for (std::size_t j = 0; j < 4; ++j, pixel += 4 * x_.count) {
      Pixel row = Pixel::Zero();
      for (std::size_t k = 0; k < 4; ++k) row += tx.weight[k][i] * Eigen::Map<const Pixel>(pixel + 4 * k);
      sum += ty.weight[j][i] * row;
    }
    sums[i] = sums[i] + Color{sum[0], sum[1], sum[2]};
  }
}

}  // namespace gpvc::atlas
