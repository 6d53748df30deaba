// Sub-pixel samples of a tile against every face that covers them.
#include <algorithm>
#include <cmath>

#include "visibility/oracle/oracle_tile.h"

namespace gpvc::visibility::truth {
namespace {

ExactPoint exact_sample(const ExactFace& face, std::size_t number) {
  const auto& v = face.vertices();
  ExactPoint sum{v[0].x + v[1].x + v[2].x, v[0].y + v[1].y + v[2].y, v[0].w + v[1].w + v[2].w};
  if (number == 3) return sum;
  const Dyadic three(3);
  return {sum.x + three * v[number].x, sum.y + three * v[number].y, sum.w + three * v[number].w};
}

}  // namespace

Vertex sample_point(const Corners& c, std::size_t number) {
  Vertex sum{c[0].x + c[1].x + c[2].x, c[0].y + c[1].y + c[2].y, c[0].z + c[1].z + c[2].z,
             2 * (c[0].error + c[1].error + c[2].error)};
  if (number == 3) return sum;
  const Vertex& v = c[number];
  return {sum.x + 3 * v.x, sum.y + 3 * v.y, sum.z + 3 * v.z, sum.error + 6 * v.error};
}

Tile::PlacedSample Tile::place(const Sample& sample) const {
  const Corners corners = corners_of(scene_.mesh, scene_.vertices, sample.face);
  const Vertex point = sample_point(corners, sample.number);
  const double vertices = sample.number == 3 ? 3 : 6;
  const auto dx = static_cast<double>((point.x - origin_x_ * point.z) / point.z);
  const auto dy = static_cast<double>((point.y - origin_y_ * point.z) / point.z);
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  const double position_error =
      2 * static_cast<double>(point.error / point.z) + kRounding * (std::abs(dx) + std::abs(dy));
  const auto depth = static_cast<double>(point.z / static_cast<long double>(vertices));
  // Depths themselves are off by far less than `error`, which is that of a position times depth.
  const double depth_error = kRounding * depth + static_cast<double>(point.error / scene_.view.camera.fx);
  return {dx, dy, position_error, {depth, depth_error}};
}

void Tile::decide_samples(std::span<const std::uint32_t> faces, std::span<Sample> samples) {
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : (a.face != b.face ? a.face < b.face : a.number < b.number);
  });
  placed_.clear();
  first_sample_.fill(0);
  for (const Sample& sample : samples) {
    placed_.push_back(place(sample));
    ++first_sample_[sample.pixel + 1U];
  }
  for (std::size_t pixel = 0; pixel < kPixels; ++pixel) first_sample_[pixel + 1] += first_sample_[pixel];
  for (const std::uint32_t face : faces) hide_samples(face, samples);
}

void Tile::hide_samples(std::uint32_t face, std::span<Sample> samples) {
  const Box box = box_of(face);
  std::optional<LocalFace> shape;
  if (box.x0 >= box.x1) return;
  for (int y = box.y0; y < box.y1; ++y) {
    const auto first = static_cast<std::size_t>((y - y0_) * kSize + (box.x0 - x0_));
    const std::size_t last = first + static_cast<std::size_t>(box.x1 - box.x0);
    for (std::uint32_t s = first_sample_[first]; s < first_sample_[last]; ++s) {
      Sample& sample = samples[s];
      if (sample.hidden || sample.face == face) continue;
      if (!shape) shape = local(face);
      hide_sample(face, *shape, sample, placed_[s]);
    }
  }
}

void Tile::hide_sample(std::uint32_t face, const LocalFace& shape, Sample& sample, const PlacedSample& placed) {
  LocalFace::Values values;
  const Answer covered = shape.covers(placed.dx, placed.dy, placed.position_error, values);
  if (covered == Answer::no) return;
  const LocalFace::Depth depth = shape.depth(values, placed.position_error);
  const double gap = placed.depth.error + depth.error + 1.0001 * kTieDepth * placed.depth.value;
  if (depth.value > placed.depth.value + gap) return;
  if (covered == Answer::yes && depth.value < placed.depth.value - gap) {
    sample.hidden = true;
    return;
  }
  if (covered == Answer::yes && same_triangle(face, sample.face)) {
    sample.disputed = true;
    sample.beaten |= precedes(face, sample.face);
    return;
  }
  const ExactPoint point = exact_sample(exact(sample.face), sample.number);
  const ExactFace::Coverage coverage = exact(face).coverage(point);
  if (coverage.margin_px < -static_cast<long double>(kTiePx)) return;
  const ExactDepth there = exact(face).depth(point), own = exact(sample.face).depth(point);
  if (!there.ahead) return;
  const int order = compare(there, own);
  const bool level = relative_gap(there, own) <= kTieDepth;
  if (order > 0 && !level) return;
  if (coverage.margin_px > kTiePx && !level) {
    sample.hidden = true;
    return;
  }
  sample.disputed = true;
  sample.beaten |= coverage.inside && (order < 0 || (order == 0 && precedes(face, sample.face)));
}

}  // namespace gpvc::visibility::truth
