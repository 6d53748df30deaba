#include "visibility/subpixel.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <optional>

#include "visibility/exact.h"

namespace gpvc {
namespace {

/// A sample sees the face only if it is in the image: on the frame, and in the photo once distorted.
bool in_image(const ClassifyView& view, double x, double y) {
  const double w = view.camera.width, h = view.camera.height;
  if (!(x >= 0 && y >= 0 && x <= w && y <= h)) return false;
  return view.mask.contains(PixelPoint{x, y});
}

/// About eight samples a cell, two steps of QuickFace::possible(), up to 16 x 16 cells.
std::uint8_t cells_for(std::uint32_t samples) {
  std::uint32_t side = 1;
  while (side < 16 && 8 * side * side < samples) ++side;
  return static_cast<std::uint8_t>(side);
}

/// Column or row of cells; grows with the position, whatever the rounding.
std::uint32_t cell_of(double position, std::int32_t pixel, std::uint32_t side) {
  const double cell = (position - pixel) * side;
  return static_cast<std::uint32_t>(std::min(std::max(cell, 0.0), side - 1.0));
}

}  // namespace

/// A face that may hide samples; made ready for the exact predicates when they are first needed.
struct SubpixelResolver::Occluder {
  Occluder(const ClassifyView& seen, const QuickLimits& limits, FaceId occluding, const FaceBounds& bounds)
      : view(seen),
        face(occluding),
        quick(seen.quick(limits, occluding, bounds)),
        depths(seen.depths(occluding)) {}

  /// Whether it covers the sample of a face, whose depths are given, and is nearer there.
  bool hides(double x, double y, FaceId sampled, const DepthRange& other) {
    if (depths.nearest > other.farthest) return false;
    if (depths.farthest < other.nearest && quick.contains(x, y)) return true;
    if (!exact) raster = view.raster(face);
    exact = true;
    if (raster.facing == Facing::edge_on) return false;
    const FacePoint here = face_point(raster, x, y);
    if (!covers_exactly(here)) return false;
    const RasterFace own = view.raster(sampled);
    const int order = compare_depth_exactly(here, face_point(own, x, y));
    return order < 0 || (order == 0 && face < sampled);
  }

  const ClassifyView& view;
  FaceId face;
  QuickFace quick;
  DepthRange depths;
  bool exact = false;  ///< raster is set
  RasterFace raster;
};

void SubpixelResolver::start(const ClassifyView& view, std::size_t faces) {
  if (width_ != view.camera.width || height_ != view.camera.height) {
    width_ = view.camera.width;
    height_ = view.camera.height;
    stride_ = (static_cast<std::size_t>(width_) + 63) / 64;
    const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    first_cell_.assign(pixels, 0);
    cells_a_side_.assign(pixels, 0);
    occupied_.assign(stride_ * static_cast<std::size_t>(height_), 0);
    tiles_.assign(stride_ * ((static_cast<std::size_t>(height_) + 63) / 64), 0);
  }
  limits_ = view.quick_limits();
  samples_.resize(faces * kSubpixelSamples);
  depths_.resize(faces);
}

/// Calls back for every pixel with samples, tile by tile.
template <class Callback>
void SubpixelResolver::for_each_occupied(Callback&& callback) const {
  for (std::size_t tile = 0; tile < tiles_.size(); ++tile) {
    if (tiles_[tile] == 0) continue;
    const std::size_t word = tile % stride_, row = tile / stride_ * 64;
    for (std::size_t y = row; y < std::min(row + 64, static_cast<std::size_t>(height_)); ++y)
      for (std::uint64_t bits = occupied_[y * stride_ + word]; bits != 0; bits &= bits - 1)
        callback(y * static_cast<std::size_t>(width_) + word * 64 +
                 static_cast<std::size_t>(std::countr_zero(bits)));
  }
}

void SubpixelResolver::make_samples(const ClassifyView& view, std::size_t number, FaceId face) {
  const auto& v = view.raster(face).vertex;
  depths_[number] = view.depths(face);
  const ProjectedVertex centroid{v[0].u + v[1].u + v[2].u, v[0].v + v[1].v + v[2].v,
                                 v[0].z + v[1].z + v[2].z};
  for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
    ProjectedVertex q = centroid;
    if (k < 3) q = {q.u + 3 * v[k].u, q.v + 3 * v[k].v, q.z + 3 * v[k].z};
    const double x = q.u / q.z, y = q.v / q.z;
    Sample& sample = samples_[number * kSubpixelSamples + k];
    sample = {x, y, kNowhere, kNowhere};
    if (!in_image(view, x, y)) continue;
    const int column = std::min(static_cast<int>(x), width_ - 1);
    const int row = std::min(static_cast<int>(y), height_ - 1);
    const std::size_t word = static_cast<std::size_t>(column) / 64;
    const std::size_t pixel =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
    sample.pixel = static_cast<std::uint32_t>(pixel);
    std::atomic_ref(first_cell_[pixel]).fetch_add(1, std::memory_order_relaxed);
    // Mostly set by a sample before: looking is cheaper than a locked write.
    const std::uint64_t bit = std::uint64_t{1} << (column % 64);
    std::atomic_ref bits(occupied_[static_cast<std::size_t>(row) * stride_ + word]);
    if ((bits.load(std::memory_order_relaxed) & bit) == 0) bits.fetch_or(bit, std::memory_order_relaxed);
    std::atomic_ref tile(tiles_[static_cast<std::size_t>(row) / 64 * stride_ + word]);
    if (tile.load(std::memory_order_relaxed) == 0) tile.store(1, std::memory_order_relaxed);
  }
}

void SubpixelResolver::make_cells() {
  std::uint32_t cells = 0;
  for_each_occupied([&](std::size_t pixel) {
    const std::uint32_t side = cells_for(first_cell_[pixel]);
    cells_a_side_[pixel] = static_cast<std::uint8_t>(side);
    first_cell_[pixel] = cells;
    cells += side * side;
  });
  cell_end_.assign(cells, 0);
  tbb::parallel_for(std::size_t{0}, samples_.size(), [&](std::size_t number) {
    Sample& sample = samples_[number];
    if (sample.pixel == kNowhere) return;
    const std::uint32_t side = cells_a_side_[sample.pixel];
    sample.at = first_cell_[sample.pixel];
    if (side > 1) {
      const auto width = static_cast<std::uint32_t>(width_);
      const auto x = static_cast<std::int32_t>(sample.pixel % width);
      const auto y = static_cast<std::int32_t>(sample.pixel / width);
      sample.at += cell_of(sample.y, y, side) * side + cell_of(sample.x, x, side);
    }
    std::atomic_ref(cell_end_[sample.at]).fetch_add(1, std::memory_order_relaxed);
  });
}

/// Counting sort. The order within a cell depends on the threads; what is done with the samples does not.
void SubpixelResolver::place(std::span<const FaceId> faces) {
  std::uint32_t begin = 0;
  for (std::uint32_t& cell : cell_end_) {
    const std::uint32_t count = cell;
    cell = begin;
    begin += count;
  }
  placed_.resize(begin);
  x_.resize(begin + 3);
  y_.resize(begin + 3);
  visible_.assign(begin, 1);
  tbb::parallel_for(std::size_t{0}, samples_.size(), [&](std::size_t number) {
    Sample& sample = samples_[number];
    if (sample.pixel == kNowhere) return;
    const std::size_t face = number / kSubpixelSamples;
    sample.at = std::atomic_ref(cell_end_[sample.at]).fetch_add(1, std::memory_order_relaxed);
    placed_[sample.at] = {faces[face], static_cast<std::uint32_t>(face)};
    x_[sample.at] = sample.x;
    y_[sample.at] = sample.y;
  });
}

bool SubpixelResolver::any_in(const PixelBox& pixels) const {
  if (pixels.empty()) return false;
  for (std::int32_t row = pixels.y0 / 64; row <= (pixels.y1 - 1) / 64; ++row)
    for (std::int32_t column = pixels.x0 / 64; column <= (pixels.x1 - 1) / 64; ++column)
      if (tiles_[static_cast<std::size_t>(row) * stride_ + static_cast<std::size_t>(column)] != 0)
        return true;
  return false;
}

void SubpixelResolver::hide(Occluder& occluder, std::size_t at) {
  std::atomic_ref visible(visible_[at]);
  const Placed& sample = placed_[at];
  if (sample.face == occluder.face || visible.load(std::memory_order_relaxed) == 0) return;
  if (occluder.hides(x_[at], y_[at], sample.face, depths_[sample.number]))
    visible.store(0, std::memory_order_relaxed);
}

/// The samples of cells first .. last that lie in the bounds.
void SubpixelResolver::hide_in_cells(Occluder& occluder, const FaceBounds& bounds, std::size_t first,
                                     std::size_t last) {
  const std::size_t end = cell_end_[last];
  for (std::size_t i = first == 0 ? 0 : cell_end_[first - 1]; i < end; i += 64) {
    const std::size_t count = std::min<std::size_t>(end - i, 64);
    if (occluder.quick.usable()) {
      std::uint64_t bits = occluder.quick.possible(x_.data() + i, y_.data() + i, count, bounds);
      for (; bits != 0; bits &= bits - 1)
        hide(occluder, i + static_cast<std::size_t>(std::countr_zero(bits)));
    } else {
      for (std::size_t k = i; k < i + count; ++k)
        if (!bounds.bounded ||
            (x_[k] >= bounds.x0 && x_[k] <= bounds.x1 && y_[k] >= bounds.y0 && y_[k] <= bounds.y1))
          hide(occluder, k);
    }
  }
}

void SubpixelResolver::hide_in_pixel(Occluder& occluder, const FaceBounds& bounds, std::int32_t x,
                                     std::int32_t y) {
  const std::size_t pixel =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  const std::size_t first = first_cell_[pixel], side = cells_a_side_[pixel];
  if (side == 1 || !bounds.bounded) return hide_in_cells(occluder, bounds, first, first + side * side - 1);
  const auto cells = static_cast<std::uint32_t>(side);
  const std::uint32_t x0 = cell_of(bounds.x0, x, cells), x1 = cell_of(bounds.x1, x, cells);
  const std::uint32_t y0 = cell_of(bounds.y0, y, cells), y1 = cell_of(bounds.y1, y, cells);
  for (std::size_t row = y0; row <= y1; ++row)
    hide_in_cells(occluder, bounds, first + row * side + x0, first + row * side + x1);
}

/// Of a word of pixels of a row, those of x0 .. x1 - 1 that have samples.
std::uint64_t SubpixelResolver::occupied(std::size_t word, std::int32_t y, std::int32_t x0,
                                         std::int32_t x1) const {
  std::uint64_t bits = occupied_[static_cast<std::size_t>(y) * stride_ + word];
  if (word == static_cast<std::size_t>(x0) / 64) bits &= ~std::uint64_t{0} << (x0 % 64);
  if (word == static_cast<std::size_t>(x1 - 1) / 64) bits &= ~std::uint64_t{0} >> (63 - (x1 - 1) % 64);
  return bits;
}

void SubpixelResolver::hide_in_row(Occluder& occluder, const FaceBounds& bounds, std::int32_t y) {
  const PixelBox pixels = touched_pixels(bounds, {0, y, width_, y + 1});
  if (pixels.x0 >= pixels.x1) return;
  const auto last_word = static_cast<std::size_t>(pixels.x1 - 1) / 64;
  for (std::size_t word = static_cast<std::size_t>(pixels.x0) / 64; word <= last_word; ++word)
    for (std::uint64_t bits = occupied(word, y, pixels.x0, pixels.x1); bits != 0; bits &= bits - 1)
      hide_in_pixel(occluder, bounds, static_cast<std::int32_t>(word * 64) + std::countr_zero(bits), y);
}

void SubpixelResolver::hide_behind(const ClassifyView& view, FaceId face) {
  const FaceBounds bounds = view.bounds(face);
  if (outside(bounds, width_, height_)) return;
  const PixelBox pixels = touched_pixels(bounds, view.frame());
  if (pixels.empty()) return;
  // A sliver across many rows fills little of its rectangle.
  const bool narrow = pixels.x1 - pixels.x0 > 2 && pixels.y1 - pixels.y0 > 2 && limits_.holds(bounds);
  const auto first_word = static_cast<std::size_t>(pixels.x0) / 64;
  const auto last_word = static_cast<std::size_t>(pixels.x1 - 1) / 64;
  std::optional<Occluder> occluder;
  for (std::int32_t y = pixels.y0; y < pixels.y1; ++y) {
    std::uint64_t any = 0;
    for (std::size_t word = first_word; word <= last_word; ++word)
      any |= occupied(word, y, pixels.x0, pixels.x1);
    if (any == 0) continue;
    if (!occluder) occluder.emplace(view, limits_, face, bounds);
    hide_in_row(*occluder, narrow ? occluder->quick.in_row(y) : bounds, y);
  }
}

/// Only what was written is cleared: the tables are as large as the image.
void SubpixelResolver::clear() {
  for_each_occupied([&](std::size_t pixel) { first_cell_[pixel] = 0; });
  for (std::size_t tile = 0; tile < tiles_.size(); ++tile) {
    if (tiles_[tile] == 0) continue;
    tiles_[tile] = 0;
    const std::size_t row = tile / stride_ * 64;
    for (std::size_t y = row; y < std::min(row + 64, static_cast<std::size_t>(height_)); ++y)
      occupied_[y * stride_ + tile % stride_] = 0;
  }
}

void SubpixelResolver::resolve(const ClassifyView& view, std::span<const FaceId> faces,
                               std::span<const PixelBox> blocks, std::size_t faces_per_block) {
  start(view, faces.size());
  if (faces.empty()) return;
  tbb::parallel_for(std::size_t{0}, faces.size(), [&](std::size_t i) { make_samples(view, i, faces[i]); });
  make_cells();
  place(faces);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    if (!any_in(blocks[block])) return;
    const std::size_t last = std::min((block + 1) * faces_per_block, view.mesh.faces.size());
    for (std::size_t f = block * faces_per_block; f < last; ++f)
      hide_behind(view, FaceId{static_cast<std::uint32_t>(f)});
  });
  clear();
}

std::uint32_t SubpixelResolver::visible(std::size_t number) const {
  std::uint32_t count = 0;
  for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
    const std::uint32_t at = samples_[number * kSubpixelSamples + k].at;
    count += at == kNowhere ? 0U : visible_[at];
  }
  return count;
}

}  // namespace gpvc
