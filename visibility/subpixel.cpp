#include "visibility/subpixel.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "visibility/exact.h"

namespace gpvc {
namespace {

/// A sample sees the face only if it is in the image: on the frame, and in the photo once distorted.
bool in_image(const ClassifyView& view, double x, double y) {
  const double w = view.camera.width, h = view.camera.height;
  if (!(x >= 0 && y >= 0 && x <= w && y <= h)) return false;
  return view.mask.whole() || in_photo(view.camera, {x, y});
}

}  // namespace

void SubpixelResolver::start(const ClassifyView& view, std::size_t faces) {
  if (width_ != view.camera.width || height_ != view.camera.height) {
    width_ = view.camera.width;
    height_ = view.camera.height;
    stride_ = (static_cast<std::size_t>(width_) + 63) / 64;
    end_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
    occupied_.assign(stride_ * static_cast<std::size_t>(height_), 0);
    tiles_.assign(stride_ * ((static_cast<std::size_t>(height_) + 63) / 64), 0);
  }
  samples_.resize(faces * kSubpixelSamples);
  visible_.assign(faces * kSubpixelSamples, 0);
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

void SubpixelResolver::place(const ClassifyView& view, std::size_t number, FaceId face) {
  const auto& v = view.raster(face).vertex;
  const ProjectedVertex centroid{v[0].u + v[1].u + v[2].u, v[0].v + v[1].v + v[2].v,
                                 v[0].z + v[1].z + v[2].z};
  for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
    ProjectedVertex q = centroid;
    if (k < 3) q = {q.u + 3 * v[k].u, q.v + 3 * v[k].v, q.z + 3 * v[k].z};
    const auto sample = static_cast<std::uint32_t>(number * kSubpixelSamples + k);
    const double x = q.u / q.z, y = q.v / q.z;
    samples_[sample] = {x, y, face, kNoPixel};
    if (!in_image(view, x, y)) continue;
    visible_[sample] = 1;
    const int column = std::min(static_cast<int>(x), width_ - 1);
    const int row = std::min(static_cast<int>(y), height_ - 1);
    const std::size_t word = static_cast<std::size_t>(column) / 64;
    const std::size_t pixel =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
    samples_[sample].pixel = static_cast<std::uint32_t>(pixel);
    std::atomic_ref(end_[pixel]).fetch_add(1, std::memory_order_relaxed);
    std::atomic_ref(occupied_[static_cast<std::size_t>(row) * stride_ + word])
        .fetch_or(std::uint64_t{1} << (column % 64), std::memory_order_relaxed);
    std::atomic_ref(tiles_[static_cast<std::size_t>(row) / 64 * stride_ + word])
        .store(1, std::memory_order_relaxed);
  }
}

/// Counting sort. The order within a pixel depends on the threads; what is done with the samples does not.
void SubpixelResolver::sort_by_pixel() {
  std::uint32_t begin = 0;
  for_each_occupied([&](std::size_t pixel) {
    const std::uint32_t count = end_[pixel];
    end_[pixel] = begin;
    begin += count;
  });
  placed_.resize(begin);
  tbb::parallel_for(std::size_t{0}, samples_.size(), [&](std::size_t number) {
    const Sample& sample = samples_[number];
    if (sample.pixel == kNoPixel) return;
    const std::uint32_t at = std::atomic_ref(end_[sample.pixel]).fetch_add(1, std::memory_order_relaxed);
    placed_[at] = {static_cast<float>(sample.x), static_cast<float>(sample.y),
                   static_cast<std::uint32_t>(number), sample.pixel};
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

void SubpixelResolver::hide_in_pixel(const ClassifyView& view, FaceId face, const RasterFace& raster,
                                     const FaceBounds& bounds, std::size_t pixel) {
  for (std::uint32_t i = end_[pixel]; i > 0 && placed_[i - 1].pixel == pixel; --i) {
    const Placed& placed = placed_[i - 1];
    // Rounded by 2^-24 of its position; the bounds are wider than the face by three times that.
    if (bounds.bounded &&
        (placed.x < bounds.x0 || placed.x > bounds.x1 || placed.y < bounds.y0 || placed.y > bounds.y1))
      continue;
    const Sample& sample = samples_[placed.sample];
    if (sample.face == face) continue;
    if (std::atomic_ref(visible_[placed.sample]).load(std::memory_order_relaxed) == 0) continue;
    const FacePoint here = face_point(raster, sample.x, sample.y);
    if (!covers_exactly(here)) continue;
    const RasterFace own = view.raster(sample.face);
    const int order = compare_depth_exactly(here, face_point(own, sample.x, sample.y));
    if (order < 0 || (order == 0 && face < sample.face))
      std::atomic_ref(visible_[placed.sample]).store(0, std::memory_order_relaxed);
  }
}

void SubpixelResolver::hide_behind(const ClassifyView& view, FaceId face) {
  const FaceBounds bounds = view.bounds(face);
  if (outside(bounds, width_, height_)) return;
  const PixelBox pixels = touched_pixels(bounds, view.frame());
  if (pixels.empty()) return;
  const auto first_word = static_cast<std::size_t>(pixels.x0) / 64;
  const auto last_word = static_cast<std::size_t>(pixels.x1 - 1) / 64;
  const std::uint64_t first_bits = ~std::uint64_t{0} << (pixels.x0 % 64);
  const std::uint64_t last_bits = ~std::uint64_t{0} >> (63 - (pixels.x1 - 1) % 64);
  RasterFace raster;
  bool prepared = false;
  for (std::int32_t y = pixels.y0; y < pixels.y1; ++y)
    for (std::size_t word = first_word; word <= last_word; ++word) {
      std::uint64_t bits = occupied_[static_cast<std::size_t>(y) * stride_ + word];
      if (word == first_word) bits &= first_bits;
      if (word == last_word) bits &= last_bits;
      for (; bits != 0; bits &= bits - 1) {
        if (!prepared) {
          raster = view.raster(face);
          if (raster.facing == Facing::edge_on) return;
          prepared = true;
        }
        hide_in_pixel(view, face, raster, bounds,
                      static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + word * 64 +
                          static_cast<std::size_t>(std::countr_zero(bits)));
      }
    }
}

void SubpixelResolver::resolve(const ClassifyView& view, std::span<const FaceId> faces,
                               std::span<const PixelBox> blocks, std::size_t faces_per_block) {
  start(view, faces.size());
  if (faces.empty()) return;
  tbb::parallel_for(std::size_t{0}, faces.size(), [&](std::size_t i) { place(view, i, faces[i]); });
  sort_by_pixel();
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    if (!any_in(blocks[block])) return;
    const std::size_t last = std::min((block + 1) * faces_per_block, view.mesh.faces.size());
    for (std::size_t f = block * faces_per_block; f < last; ++f)
      hide_behind(view, FaceId{static_cast<std::uint32_t>(f)});
  });
  // Only what was written is cleared: the tables are as large as the image.
  for_each_occupied([&](std::size_t pixel) { end_[pixel] = 0; });
  for (std::size_t tile = 0; tile < tiles_.size(); ++tile) {
    if (tiles_[tile] == 0) continue;
    tiles_[tile] = 0;
    for (std::size_t y = tile / stride_ * 64;
         y < std::min(tile / stride_ * 64 + 64, static_cast<std::size_t>(height_)); ++y)
      occupied_[y * stride_ + tile % stride_] = 0;
  }
}

std::uint32_t SubpixelResolver::visible(std::size_t number) const {
  std::uint32_t count = 0;
  for (std::size_t k = 0; k < kSubpixelSamples; ++k) count += visible_[number * kSubpixelSamples + k];
  return count;
}

}  // namespace gpvc
