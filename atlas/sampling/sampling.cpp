#include "atlas/sampling/sampling.h"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cstring>

#include "atlas/sampling/pixel_floats.h"
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

namespace {

/// pixel(x, y) gives the color of a pixel.
template <typename Pixel>
Color bicubic(int width, int height, double x, double y, Overshoot overshoot, const Pixel& pixel) {
  const Taps tx = taps(x, width), ty = taps(y, height);
  const auto wx = catmull_rom(tx.fraction), wy = catmull_rom(ty.fraction);
  Color sum;
  for (std::size_t j = 0; j < 4; ++j) {
    Color row;
    for (std::size_t i = 0; i < 4; ++i) row = row + wx[i] * pixel(tx.index[i], ty.index[j]);
    sum = sum + wy[j] * row;
  }
  if (overshoot == Overshoot::kept) return sum;
  const Color a = pixel(tx.index[1], ty.index[1]), b = pixel(tx.index[2], ty.index[1]),
              c = pixel(tx.index[1], ty.index[2]), d = pixel(tx.index[2], ty.index[2]);
  const auto limited = [](float value, float p, float q, float r, float s) {
    return std::clamp(value, std::min({p, q, r, s}), std::max({p, q, r, s}));
  };
  return {limited(sum.r, a.r, b.r, c.r, d.r), limited(sum.g, a.g, b.g, c.g, d.g), limited(sum.b, a.b, b.b, c.b, d.b)};
}

}  // namespace

Color sample_bicubic(const Image& photo, double x, double y) {
  // Inside a photo the four pixels of a row lie beside each other, and all of a pixel is computed at once, in the same steps.
  const double left = x - 0.5, above = y - 0.5;
  if (left >= 1 && above >= 1 && left < photo.width - 3 && above < photo.height - 3) {
    const int column = static_cast<int>(left), row = static_cast<int>(above);
    const auto wx = catmull_rom(static_cast<float>(left - column)), wy = catmull_rom(static_cast<float>(above - row));
    FourFloats sum{};
    for (std::size_t j = 0; j < 4; ++j) {
      const std::uint8_t* pixel = photo.at(column - 1, row - 1 + static_cast<int>(j));
      FourFloats along{};
      for (std::size_t i = 0; i < 4; ++i, pixel += 3) {
        static_assert(std::endian::native == std::endian::little);  // the first byte is the lowest
        std::uint32_t word = 0;
        std::memcpy(&word, pixel, sizeof word);
        along += wx[i] * in_place(word);
      }
      sum += wy[j] * along;
    }
    sum *= kOutOfPlace;
    return {sum[0], sum[1], sum[2]};
  }
  return bicubic(photo.width, photo.height, x, y, Overshoot::kept,
                 [&](int column, int row) { return load(photo.at(column, row)); });
}

Color sample_bicubic(const Layer& photo, double x, double y, Overshoot overshoot) {
  return bicubic(photo.width, photo.height, x, y, overshoot,
                 [&](int column, int row) { return photo.at(column, row); });
}

Color sample_bilinear(const Image& photo, double x, double y) {
  const auto [r, g, b] = bilinear<float>(photo, x, y);
  return {r, g, b};
}

Color sample_bilinear(const Layer& photo, double x, double y) {
  const auto [r, g, b] = bilinear_of<float>(photo.width, photo.height, x, y, [&](int column, int row) {
    const Color color = photo.at(column, row);
    return std::array<float, 3>{color.r, color.g, color.b};
  });
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

/// line(row, first, count, to): writes so many pixels of a row, columns beyond the photo clamped.
template <typename Line>
void PhotoPatch::load_lines(int width, int height, const PhotoPoint& low, const PhotoPoint& high, const Line& line) {
  x_ = Axis(low.x, high.x, width);
  y_ = Axis(low.y, high.y, height);
  pixels_.resize(4 * pixel_index(0, y_.count, x_.count));
  float* to = pixels_.data();
  for (int j = 0; j < y_.count; ++j, to += 4 * x_.count) line(std::clamp(y_.first + j, 0, height - 1), to);
}

void PhotoPatch::load(const Image& photo, const PhotoPoint& low, const PhotoPoint& high) {
  load_lines(photo.width, photo.height, low, high, [&](int row, float* to) {
    const std::uint8_t* line = photo.at(0, row);
    for (int i = 0; i < x_.count; ++i, to += 4) {
      const std::uint8_t* pixel = line + 3 * std::clamp(x_.first + i, 0, photo.width - 1);
      for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(pixel[c]);
    }
  });
}

void PhotoPatch::load(const Layer& photo, const PhotoPoint& low, const PhotoPoint& high) {
  load_lines(photo.width, photo.height, low, high, [&](int row, float* to) {
    for (int i = 0; i < x_.count; ++i, to += 4) {
      const Color color = photo.at(std::clamp(x_.first + i, 0, photo.width - 1), row);
      to[0] = color.r;
      to[1] = color.g;
      to[2] = color.b;
    }
  });
}

template <Overshoot kOvershoot>
void PhotoPatch::add_row_with(const PhotoPoint& first, const PhotoPoint& step, std::span<Color, kRow> sums) const {
  using Pixel = Eigen::Array4f;
  const Taps tx(x_, first.x, step.x), ty(y_, first.y, step.y);
  const auto line = static_cast<std::ptrdiff_t>(4 * x_.count);
  for (std::size_t i = 0; i < kRow; ++i) {
    const float* corner = pixels_.data() + 4 * pixel_index(tx.first[i], ty.first[i], x_.count);
    const float* pixel = corner;
    Pixel sum = Pixel::Zero();
    for (std::size_t j = 0; j < 4; ++j, pixel += line) {
      Pixel row = Pixel::Zero();
      for (std::size_t k = 0; k < 4; ++k) row += tx.weight[k][i] * Eigen::Map<const Pixel>(pixel + 4 * k);
      sum += ty.weight[j][i] * row;
    }
    if constexpr (kOvershoot == Overshoot::limited) {
      const auto at = [&](std::ptrdiff_t x, std::ptrdiff_t y) {
        return Eigen::Map<const Pixel>(corner + 4 * x + line * y);
      };
      const Pixel least = at(1, 1).min(at(2, 1)).min(at(1, 2).min(at(2, 2)));
      const Pixel most = at(1, 1).max(at(2, 1)).max(at(1, 2).max(at(2, 2)));
      sum = sum.max(least).min(most);
    }
    sums[i] = sums[i] + Color{sum[0], sum[1], sum[2]};
  }
}

void PhotoPatch::add_row(const PhotoPoint& first, const PhotoPoint& step, std::span<Color, kRow> sums,
                         Overshoot overshoot) const {
  if (overshoot == Overshoot::kept)
    add_row_with<Overshoot::kept>(first, step, sums);
  else
    add_row_with<Overshoot::limited>(first, step, sums);
}

}  // namespace gpvc::atlas
