#include "visibility/subpixel.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "visibility/wide.h"

namespace gpvc {
namespace {

/// Few enough pixels that the samples of a tile fit a processor's cache where there are a dozen a pixel,
/// enough that most faces smaller than pixels touch one tile.
constexpr std::int32_t kTileSide = 32;
constexpr std::size_t kTilesPerRegion = 4;  ///< along each axis
/// More tiles than this, a megapixel, few faces touch: they need no lists.
constexpr std::int64_t kVast = 1024;
/// From so many occluders on threads share a tile.
constexpr std::size_t kCrowd = 1 << 16;

/// How far ahead memory is asked for: what a tile needs lies in many places.
constexpr std::size_t kAhead = 8;

constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();

/// A sample sees the face only if it is in the image: on the frame, and in the photo once distorted.
bool in_image(const ClassifyView& view, double x, double y) {
  const double w = view.camera.width, h = view.camera.height;
  if (!(x >= 0 && y >= 0 && x <= w && y <= h)) return false;
  return view.mask.contains(PixelPoint{x, y});
}

/// The midpoints from the centroid to the vertices, and the centroid.
GPVC_WIDE_CLONES void place_samples(const std::array<ProjectedVertex, 3>& v, double* x, double* y) {
  const FourDoubles all{1, 1, 1, 1};
  const FourDoubles u = all * (v[0].u + v[1].u + v[2].u) + 3 * FourDoubles{v[0].u, v[1].u, v[2].u, 0};
  const FourDoubles w = all * (v[0].v + v[1].v + v[2].v) + 3 * FourDoubles{v[0].v, v[1].v, v[2].v, 0};
  const FourDoubles z = all * (v[0].z + v[1].z + v[2].z) + 3 * FourDoubles{v[0].z, v[1].z, v[2].z, 0};
  const FourDoubles px = u / z, py = w / z;
  std::memcpy(x, &px, sizeof(px));
  std::memcpy(y, &py, sizeof(py));
}

/// The corners of a face to come, and the face that comes after as many again.
void prefetch(const ClassifyView& view, std::span<const std::uint32_t> faces, std::size_t at) {
  if (at + 2 * kAhead >= faces.size()) return;
  __builtin_prefetch(&view.mesh.faces[faces[at + 2 * kAhead]]);
  for (const std::uint32_t vertex : view.mesh.faces[faces[at + kAhead]])
    __builtin_prefetch(&view.projected.positions[vertex]);
}

}  // namespace

void SubpixelResolver::TileLists::start(std::size_t blocks, std::size_t tiles) {
  blocks_.resize(blocks);
  end_.assign(tiles, 0);
}

void SubpixelResolver::TileLists::sort() {
  // Entries that follow one another mostly share a tile: one atomic operation for all of them.
  const auto for_each_run = [&](auto&& run) {
    tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t number) {
      const auto& found = blocks_[number].found_;
      for (std::size_t first = 0, next = 0; first < found.size(); first = next) {
        while (next < found.size() && found[next].tile == found[first].tile) ++next;
        run(std::atomic_ref(end_[found[first].tile]), std::span(found).subspan(first, next - first));
      }
    });
  };
  for_each_run([](std::atomic_ref<std::size_t> count, auto entries) {
    count.fetch_add(entries.size(), std::memory_order_relaxed);
  });
  std::size_t begin = 0;
  for (std::size_t& tile : end_) {
    const std::size_t count = tile;
    tile = begin;
    begin += count;
  }
  numbers_.resize(begin);
  for_each_run([&](std::atomic_ref<std::size_t> end, auto entries) {
    std::size_t at = end.fetch_add(entries.size(), std::memory_order_relaxed);
    for (const auto& entry : entries) numbers_[at++] = entry.number;
  });
}

void SubpixelResolver::start(const ClassifyView& view, std::size_t faces) {
  width_ = view.camera.width;
  height_ = view.camera.height;
  const auto squares = [](std::size_t length, std::size_t side) { return (length + side - 1) / side; };
  tiles_across_ = squares(static_cast<std::size_t>(width_), kTileSide);
  tiles_down_ = squares(static_cast<std::size_t>(height_), kTileSide);
  regions_across_ = squares(tiles_across_, kTilesPerRegion);
  limits_ = view.quick_limits();
  samples_.resize(faces);
  visible_.assign(faces, 0);
  vast_.clear();
}

/// \pre on the frame. A position on its right or lower border belongs to the last tile.
std::uint32_t SubpixelResolver::tile_of(double x, double y) const {
  const auto column = static_cast<std::size_t>(std::min(static_cast<std::int32_t>(x), width_ - 1));
  const auto row = static_cast<std::size_t>(std::min(static_cast<std::int32_t>(y), height_ - 1));
  return static_cast<std::uint32_t>(row / kTileSide * tiles_across_ + column / kTileSide);
}

void SubpixelResolver::make_samples(const ClassifyView& view, std::span<const FaceId> faces) {
  samples_by_tile_.start(block_count(faces.size()), tiles_across_ * tiles_down_);
  for_each_block(faces.size(), [&](std::size_t number, std::size_t begin, std::size_t end) {
    TileLists::Block& block = samples_by_tile_.block(number);
    block.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const Triangle& t = view.mesh.faces[index(faces[i])];
      const auto& v = view.projected.vertices;
      Samples& samples = samples_[i];
      place_samples(nearest_first(v[t[0]], v[t[1]], v[t[2]]), samples.x.data(), samples.y.data());
      std::array<std::uint32_t, kSubpixelSamples> tiles{};
      std::size_t listed = 0;
      for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
        if (!in_image(view, samples.x[k], samples.y[k])) {
          samples.x[k] = kNowhere;
          continue;
        }
        const std::uint32_t tile = tile_of(samples.x[k], samples.y[k]);
        auto* const last = tiles.data() + listed;
        if (std::find(tiles.data(), last, tile) != last) continue;
        tiles[listed++] = tile;
        block.add(tile, static_cast<std::uint32_t>(i));
      }
    }
  });
  samples_by_tile_.sort();
}

void SubpixelResolver::find_tiles() {
  tiles_.clear();
  occupied_.assign(tiles_across_ * tiles_down_, 0);
  regions_.assign(regions_across_ * ((tiles_down_ + kTilesPerRegion - 1) / kTilesPerRegion), 0);
  for (std::size_t tile = 0; tile < occupied_.size(); ++tile) {
    if (samples_by_tile_.of(tile).empty()) continue;
    tiles_.push_back(static_cast<std::uint32_t>(tile));
    occupied_[tile] = 1;
    regions_[tile / tiles_across_ / kTilesPerRegion * regions_across_ +
             tile % tiles_across_ / kTilesPerRegion] = 1;
  }
}

bool SubpixelResolver::any_in(const PixelBox& pixels) const {
  if (pixels.empty()) return false;
  constexpr auto kSide = static_cast<std::int32_t>(kTilesPerRegion) * kTileSide;
  for (std::int32_t row = pixels.y0 / kSide; row <= (pixels.y1 - 1) / kSide; ++row)
    for (std::int32_t column = pixels.x0 / kSide; column <= (pixels.x1 - 1) / kSide; ++column)
      if (regions_[static_cast<std::size_t>(row) * regions_across_ + static_cast<std::size_t>(column)] != 0)
        return true;
  return false;
}

void SubpixelResolver::list_occluders(const ClassifyView& view, std::span<const PixelBox> blocks,
                                      std::size_t faces_per_block) {
  const std::size_t together = std::max<std::size_t>(kFacesPerBlock / faces_per_block, 1);
  const std::size_t lists = (blocks.size() + together - 1) / together;
  occluders_by_tile_.start(lists, occupied_.size());
  tbb::parallel_for(std::size_t{0}, lists, [&](std::size_t number) {
    TileLists::Block& list = occluders_by_tile_.block(number);
    list.clear();
    for (std::size_t b = number * together; b < std::min((number + 1) * together, blocks.size()); ++b) {
      if (!any_in(blocks[b])) continue;
      const std::size_t end = std::min((b + 1) * faces_per_block, view.mesh.faces.size());
      for (std::size_t f = b * faces_per_block; f < end; ++f)
        list_occluder(view, FaceId{static_cast<std::uint32_t>(f)}, list);
    }
  });
  occluders_by_tile_.sort();
}

void SubpixelResolver::list_occluder(const ClassifyView& view, FaceId face, TileLists::Block& block) {
  const FaceBounds bounds = view.bounds(face);
  if (outside(bounds, width_, height_)) return;
  const PixelBox pixels = touched_pixels(bounds, view.frame());
  if (pixels.empty()) return;
  const std::int32_t first_row = pixels.y0 / kTileSide, last_row = (pixels.y1 - 1) / kTileSide;
  std::int32_t first = pixels.x0 / kTileSide, last = (pixels.x1 - 1) / kTileSide;
  if (std::int64_t{last - first + 1} * (last_row - first_row + 1) > kVast) {
    vast_.push_back(face);
    return;
  }
  // A sliver across many tiles fills little of its rectangle.
  const bool narrow = last - first > 1 && last_row - first_row > 1 && limits_.holds(bounds);
  const QuickFace quick = narrow ? view.quick(limits_, face, bounds) : QuickFace();
  for (std::int32_t row = first_row; row <= last_row; ++row) {
    if (narrow) {
      const FaceBounds part = quick.in_rows(row * kTileSide, (row + 1) * kTileSide);
      const PixelBox touched = touched_pixels(part, view.frame());
      first = touched.x0 / kTileSide;
      last = touched.x0 < touched.x1 ? (touched.x1 - 1) / kTileSide : first - 1;
    }
    for (std::int32_t column = first; column <= last; ++column) {
      const std::size_t tile =
          static_cast<std::size_t>(row) * tiles_across_ + static_cast<std::size_t>(column);
      if (occupied_[tile] != 0) block.add(static_cast<std::uint32_t>(tile), static_cast<std::uint32_t>(face));
    }
  }
}

void SubpixelResolver::fill(std::size_t tile, std::span<const FaceId> faces, SubpixelTile& samples) const {
  const std::span<const std::uint32_t> numbers = samples_by_tile_.of(tile);
  samples.start(numbers.size() * kSubpixelSamples);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::uint32_t number = numbers[i];
    __builtin_prefetch(&samples_[numbers[std::min(i + kAhead, numbers.size() - 1)]]);
    const Samples& of = samples_[number];
    for (std::size_t k = 0; k < kSubpixelSamples; ++k)
      if (of.x[k] == of.x[k] && tile_of(of.x[k], of.y[k]) == tile)
        samples.add(faces[number], number, of.x[k], of.y[k]);
  }
  samples.sort();
}

void SubpixelResolver::count_visible(const SubpixelTile& samples) {
  samples.for_each_visible([&](std::uint32_t number) {
    std::atomic_ref(visible_[number]).fetch_add(1, std::memory_order_relaxed);
  });
}

void SubpixelResolver::resolve_tiles(const ClassifyView& view, std::span<const FaceId> faces) {
  const auto hide = [&](FaceId face, Scratch& scratch, SubpixelTile& samples) {
    samples.hide_behind(view, limits_, face, scratch.found);
  };
  tbb::parallel_for(std::size_t{0}, tiles_.size(), [&](std::size_t i) {
    const std::span<const std::uint32_t> occluders = occluders_by_tile_.of(tiles_[i]);
    if (occluders.size() >= kCrowd) return;
    Scratch& scratch = scratch_.local();
    fill(tiles_[i], faces, scratch.tile);
    for (std::size_t at = 0; at < occluders.size(); ++at) {
      prefetch(view, occluders, at);
      hide(FaceId{occluders[at]}, scratch, scratch.tile);
    }
    for (const FaceId face : vast_) hide(face, scratch, scratch.tile);
    count_visible(scratch.tile);
  });
  // One after the other: threads that wait in a loop within a loop would take up other tiles meanwhile.
  SubpixelTile samples;
  for (const std::uint32_t tile : tiles_) {
    const std::span<const std::uint32_t> occluders = occluders_by_tile_.of(tile);
    if (occluders.size() < kCrowd) continue;
    fill(tile, faces, samples);
    tbb::parallel_for(std::size_t{0}, occluders.size(),
                      [&](std::size_t i) { hide(FaceId{occluders[i]}, scratch_.local(), samples); });
    for (const FaceId face : vast_) hide(face, scratch_.local(), samples);
    count_visible(samples);
  }
}

void SubpixelResolver::resolve(const ClassifyView& view, std::span<const FaceId> faces,
                               std::span<const PixelBox> blocks, std::size_t faces_per_block) {
  start(view, faces.size());
  if (faces.empty()) return;
  make_samples(view, faces);
  find_tiles();
  list_occluders(view, blocks, faces_per_block);
  resolve_tiles(view, faces);
}

}  // namespace gpvc
