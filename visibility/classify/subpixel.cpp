#include "visibility/classify/subpixel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace gpvc::visibility {
namespace {

/// Few enough pixels that the samples of a tile fit a processor's cache where there are a dozen a pixel, enough that
/// most faces smaller than pixels touch one tile.
constexpr int kTileShift = 5;
constexpr std::int32_t kTileSide = 1 << kTileShift;
constexpr std::size_t kTilesPerRegion = 4;  ///< along each axis
/// More tiles than this, a megapixel, few faces touch, as those beside the frame are not listed: they need no lists.
constexpr std::int64_t kVast = 1024;
/// From so many faces on threads share a tile.
constexpr std::size_t kCrowd = 1 << 16;
constexpr std::size_t kCrowdPart = 1024;

/// Of a vertex in no tile, or too near its border.
constexpr std::uint32_t kNoTile = std::numeric_limits<std::uint32_t>::max();
/// What samples and rounded positions may be off. A sample is a weighted mean of the vertices: with r = 2^-53 it is off
/// by less than 16 r times the mean of their coordinates' sizes, and where that reaches 2^26 px on the frame, the face
/// reaches as far on either side of it and touches all of the frame whatever is added.
constexpr double kSlack = 0x1p-24;

FaceBounds widened(const FaceBounds& b) {
  return {b.x0 - kSlack, b.y0 - kSlack, b.x1 + kSlack, b.y1 + kSlack, b.ahead, b.bounded};
}

/// A sample sees the face only if it is in the image: on the frame, and in the photo once distorted.
bool in_image(const ClassifyView& view, double x, double y) {
  const double w = view.camera.width, h = view.camera.height;
  if (!(x >= 0 && y >= 0 && x <= w && y <= h)) return false;
  return view.mask.contains(PixelPoint{x, y});
}

}  // namespace

void SubpixelResolver::start(const ClassifyView& view) {
  width_ = view.camera.width;
  height_ = view.camera.height;
  const auto squares = [](std::size_t length, std::size_t side) { return (length + side - 1) / side; };
  grid_ = TileGrid(view.frame(), kTileShift);
  regions_across_ = squares(static_cast<std::size_t>(grid_.across()), kTilesPerRegion);
  limits_ = view.quick_limits();
  tiles_.clear();
  occupied_.assign(grid_.count(), 0);
  regions_.assign(regions_across_ * squares(static_cast<std::size_t>(grid_.down()), kTilesPerRegion), 0);
  visible_.assign(view.mesh.faces.size(), 0);
  vast_.clear();
}

/// \pre on the frame. A position on its right or lower border belongs to the last tile.
std::uint32_t SubpixelResolver::tile_of(double x, double y) const {
  const auto column = static_cast<std::size_t>(std::min(static_cast<std::int32_t>(x), width_ - 1));
  const auto row = static_cast<std::size_t>(std::min(static_cast<std::int32_t>(y), height_ - 1));
  return static_cast<std::uint32_t>(row / kTileSide * static_cast<std::size_t>(grid_.across()) + column / kTileSide);
}

/// A face whose vertices have one and the same tile lies in it with all its samples.
void SubpixelResolver::find_vertex_tiles(const ClassifyView& view) {
  const std::span<const RoundedPosition> positions = view.projected.positions;
  vertex_tiles_.resize(positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, positions.size(), 4096), [&](const auto& range) {
    constexpr double kTiles = 1.0 / kTileSide;
    const double right = width_ - kSlack, bottom = height_ - kSlack;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const auto [x, y, per_z] = positions[i];
      vertex_tiles_[i] = kNoTile;
      if (!(x >= kSlack && y >= kSlack && x <= right && y <= bottom)) continue;
      const auto column = static_cast<std::int32_t>((x - kSlack) * kTiles);
      const auto row = static_cast<std::int32_t>((y - kSlack) * kTiles);
      if (static_cast<std::int32_t>((x + kSlack) * kTiles) == column &&
          static_cast<std::int32_t>((y + kSlack) * kTiles) == row)
        vertex_tiles_[i] = static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(grid_.across()) +
                           static_cast<std::uint32_t>(column);
    }
  });
}

/// The one tile that the face lies in, when that is certain.
std::uint32_t SubpixelResolver::tile_around(const Triangle& face) const {
  const std::uint32_t a = vertex_tiles_[face[0]], b = vertex_tiles_[face[1]], c = vertex_tiles_[face[2]];
  return a == b && a == c ? a : kNoTile;
}

/// Any number of threads at once.
void SubpixelResolver::occupy(std::size_t tile) {
  const auto across = static_cast<std::size_t>(grid_.across());
  const std::size_t region = tile / across / kTilesPerRegion * regions_across_ + tile % across / kTilesPerRegion;
  std::atomic_ref(occupied_[tile]).store(1, std::memory_order_relaxed);
  std::atomic_ref(regions_[region]).store(1, std::memory_order_relaxed);
}

void SubpixelResolver::find_tiles(const ClassifyView& view, std::span<const FaceCode> codes) {
  for_each_block(codes.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    std::size_t last = occupied_.size();
    for (std::size_t f = first; f < end; ++f) {
      if (codes[f] != FaceCode::no_centre) continue;
      const std::uint32_t around = tile_around(view.mesh.faces[f]);
      if (around == last) continue;
      if (around != kNoTile) {
        occupy(last = around);
        continue;
      }
      const SubpixelPositions samples = subpixel_positions(view, FaceId{static_cast<std::uint32_t>(f)});
      for (std::size_t k = 0; k < kSubpixelSamples; ++k)
        if (in_image(view, samples.x[k], samples.y[k])) occupy(tile_of(samples.x[k], samples.y[k]));
    }
  });
  for (std::size_t tile = 0; tile < occupied_.size(); ++tile)
    if (occupied_[tile] != 0) tiles_.push_back(static_cast<std::uint32_t>(tile));
}

bool SubpixelResolver::any_in(const PixelBox& pixels) const {
  if (pixels.empty()) return false;
  constexpr auto kSide = static_cast<std::int32_t>(kTilesPerRegion) * kTileSide;
  // A pixel more for samples that rounding puts beside their face.
  const std::int32_t x0 = std::max(pixels.x0 - 1, 0), x1 = std::min(pixels.x1, width_ - 1);
  const std::int32_t y0 = std::max(pixels.y0 - 1, 0), y1 = std::min(pixels.y1, height_ - 1);
  for (std::int32_t row = y0 / kSide; row <= y1 / kSide; ++row)
    for (std::int32_t column = x0 / kSide; column <= x1 / kSide; ++column)
      if (regions_[static_cast<std::size_t>(row) * regions_across_ + static_cast<std::size_t>(column)] != 0)
        return true;
  return false;
}

void SubpixelResolver::list_faces(const ClassifyView& view, std::span<const PixelBox> blocks,
                                  std::size_t faces_per_block) {
  const std::size_t together = (blocks.size() + kListParts - 1) / kListParts;
  faces_by_tile_.start(kListParts, occupied_.size());
  tbb::parallel_for(std::size_t{0}, kListParts, [&](std::size_t part) {
    TileLists::Part& list = faces_by_tile_.part(part);
    for (std::size_t b = part * together; b < std::min((part + 1) * together, blocks.size()); ++b) {
      if (!any_in(blocks[b])) continue;
      const std::size_t end = std::min((b + 1) * faces_per_block, view.mesh.faces.size());
      for (std::size_t f = b * faces_per_block; f < end; ++f) {
        const FaceId face{static_cast<std::uint32_t>(f)};
        const std::uint32_t around = tile_around(view.mesh.faces[f]);
        if (around == kNoTile) {
          list_face(view, face, list);
        } else if (occupied_[around] != 0) {
          list.add(around, face);
        }
      }
    }
  });
  faces_by_tile_.sort();
}

/// Lists the face in all tiles that it or its samples may touch.
void SubpixelResolver::list_face(const ClassifyView& view, FaceId face, TileLists::Part& list) {
  const FaceBounds bounds = widened(view.bounds(face));
  if (outside(bounds, width_, height_)) return;
  const PixelBox pixels = touched_pixels(bounds, view.frame());
  const std::int64_t tiles = grid_.touched(pixels);
  if (tiles > kVast) {
    vast_.push_back(face);
    return;
  }
  const QuickFace quick = tiles > 4 ? view.quick(limits_, face, bounds) : QuickFace();
  grid_.for_each(pixels, quick, [&](std::size_t tile) {
    if (occupied_[tile] != 0) list.add(tile, face);
  });
}

void SubpixelResolver::add_samples(const ClassifyView& view, std::size_t tile, FaceId face,
                                   SubpixelTile& samples) const {
  const SubpixelPositions at = subpixel_positions(view, face);
  if (view.mask.everywhere() && tile_around(view.mesh.faces[index(face)]) == tile) return samples.add(face, at);
  for (std::size_t k = 0; k < kSubpixelSamples; ++k)
    if (in_image(view, at.x[k], at.y[k]) && tile_of(at.x[k], at.y[k]) == tile) samples.add(face, at.x[k], at.y[k]);
}

void SubpixelResolver::fill(const ClassifyView& view, std::span<const FaceCode> codes, std::size_t tile,
                            SubpixelTile& samples) const {
  samples.start();
  const std::span<const FaceId> faces = faces_by_tile_.of(tile);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    prefetch(view, faces, i);
    if (codes[index(faces[i])] == FaceCode::no_centre) add_samples(view, tile, faces[i], samples);
  }
  for (const FaceId face : vast_)
    if (codes[index(face)] == FaceCode::no_centre) add_samples(view, tile, face, samples);
  samples.sort();
}

void SubpixelResolver::count_visible(const SubpixelTile& samples) {
  samples.for_each_face([&](FaceId face, std::uint32_t visible, std::uint32_t all) {
    std::uint8_t& sum = visible_[index(face)];
    if (all == kSubpixelSamples) {  // no other tile holds any
      sum = static_cast<std::uint8_t>(visible);
    } else {
      std::atomic_ref(sum).fetch_add(static_cast<std::uint8_t>(visible), std::memory_order_relaxed);
    }
  });
}

void SubpixelResolver::resolve_tiles(const ClassifyView& view, std::span<const FaceCode> codes) {
  const std::vector<FaceId> vast(vast_.begin(), vast_.end());
  tbb::parallel_for(std::size_t{0}, tiles_.size(), [&](std::size_t i) {
    const std::span<const FaceId> faces = faces_by_tile_.of(tiles_[i]);
    if (faces.size() >= kCrowd) return;
    auto& [samples, found] = scratch_.local();
    fill(view, codes, tiles_[i], samples);
    samples.hide_behind(view, limits_, faces, found);
    samples.hide_behind(view, limits_, vast, found);
    count_visible(samples);
  });
  // One after the other: threads that wait in a loop within a loop would take up other tiles meanwhile.
  SubpixelTile samples;
  for (const std::uint32_t tile : tiles_) {
    const std::span<const FaceId> faces = faces_by_tile_.of(tile);
    if (faces.size() < kCrowd) continue;
    fill(view, codes, tile, samples);
    const std::size_t parts = (faces.size() + kCrowdPart - 1) / kCrowdPart;
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
      const std::size_t first = part * kCrowdPart, count = std::min(kCrowdPart, faces.size() - first);
      samples.hide_behind(view, limits_, faces.subspan(first, count), scratch_.local().found);
    });
    samples.hide_behind(view, limits_, vast, scratch_.local().found);
    count_visible(samples);
  }
}

void SubpixelResolver::resolve(const ClassifyView& view, std::span<const FaceCode> codes,
                               std::span<const PixelBox> blocks, std::size_t faces_per_block) {
  start(view);
  if (std::find(codes.begin(), codes.end(), FaceCode::no_centre) == codes.end()) return;
  find_vertex_tiles(view);
  find_tiles(view, codes);
  list_faces(view, blocks, faces_per_block);
  resolve_tiles(view, codes);
}

}  // namespace gpvc::visibility
