#include "visibility/classify/subpixel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace gpvc::visibility {
namespace {

/// Tiles of 32 x 32 pixels: at a dozen samples a pixel those of a tile still fit the cache of a core, and most faces
/// smaller than a pixel touch one tile.
constexpr int kTileShift = 5;
constexpr int kRegionShift = kTileShift + 2;
/// A face that touches more tiles than this, a megapixel, is tested against every tile instead of being listed. There
/// are few: faces beside the frame are not listed at all.
constexpr std::int64_t kMostTiles = 1024;
/// From this many faces on threads share a tile, this many faces at a time.
constexpr std::size_t kFacesOfSharedTile = 1 << 16;
constexpr std::size_t kFacesAtOnce = 1024;

/// The tile of a vertex off the frame or too close to the border of its tile.
constexpr std::uint32_t kNoTile = std::numeric_limits<std::uint32_t>::max();

FaceBounds widened(const FaceBounds& b) {
  return {b.x0 - kSampleSlack, b.y0 - kSampleSlack, b.x1 + kSampleSlack, b.y1 + kSampleSlack, b.ahead, b.bounded};
}

}  // namespace

void SubpixelResolver::start(const PreparedView& view) {
  grid_ = TileGrid(view.frame(), kTileShift);
  regions_ = TileGrid(view.frame(), kRegionShift);
  tiles_.clear();
  occupied_.assign(grid_.count(), 0);
  occupied_regions_.assign(regions_.count(), 0);
  visible_.assign(view.mesh.faces.size(), 0);
  unlisted_.clear();
}

/// A face whose vertices all have the same tile lies in it with all its samples. So a vertex gets the tile that
/// contains the square of half side kSampleSlack around it, if there is one.
void SubpixelResolver::find_vertex_tiles(const PreparedView& view) {
  const std::span<const RoundedPosition> positions = view.projected.positions;
  vertex_tiles_.resize(positions.size());
  const double right = view.camera.width - kSampleSlack, bottom = view.camera.height - kSampleSlack;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, positions.size(), 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const auto [x, y, per_z] = positions[i];
      vertex_tiles_[i] = kNoTile;
      if (!(x >= kSampleSlack && y >= kSampleSlack && x <= right && y <= bottom)) continue;
      const std::size_t tile = grid_.tile_of(x - kSampleSlack, y - kSampleSlack);
      if (grid_.tile_of(x + kSampleSlack, y + kSampleSlack) == tile)
        vertex_tiles_[i] = static_cast<std::uint32_t>(tile);
    }
  });
}

/// The tile that contains the face, when there certainly is one; else kNoTile.
std::uint32_t SubpixelResolver::tile_around(const Triangle& face) const {
  const std::uint32_t a = vertex_tiles_[face[0]], b = vertex_tiles_[face[1]], c = vertex_tiles_[face[2]];
  return a == b && a == c ? a : kNoTile;
}

/// Thread-safe.
void SubpixelResolver::occupy(std::size_t tile) {
  const PixelBox pixels = grid_.pixels(tile);
  std::atomic_ref(occupied_[tile]).store(1, std::memory_order_relaxed);
  std::atomic_ref(occupied_regions_[regions_.tile_of(pixels.x0, pixels.y0)]).store(1, std::memory_order_relaxed);
}

void SubpixelResolver::find_tiles(const PreparedView& view, std::span<const FaceCode> codes) {
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
        if (view.in_image(samples.x[k], samples.y[k])) occupy(grid_.tile_of(samples.x[k], samples.y[k]));
    }
  });
  for (std::size_t tile = 0; tile < occupied_.size(); ++tile)
    if (occupied_[tile] != 0) tiles_.push_back(static_cast<std::uint32_t>(tile));
}

/// With a pixel more around the box, for samples that rounding puts beside their face.
bool SubpixelResolver::any_samples_near(const PreparedView& view, const PixelBox& pixels) const {
  if (pixels.empty()) return false;
  const PixelBox near{std::max(pixels.x0 - 1, 0), std::max(pixels.y0 - 1, 0),
                      std::min(pixels.x1 + 1, view.camera.width), std::min(pixels.y1 + 1, view.camera.height)};
  return regions_.any_of(near, [&](std::size_t region) { return occupied_regions_[region] != 0; });
}

void SubpixelResolver::list_faces(const PreparedView& view, std::span<const PixelBox> blocks,
                                  std::size_t faces_per_block) {
  const std::size_t together = (blocks.size() + kListParts - 1) / kListParts;
  faces_by_tile_.start(kListParts, occupied_.size());
  tbb::parallel_for(std::size_t{0}, kListParts, [&](std::size_t part) {
    TileLists::Part& list = faces_by_tile_.part(part);
    for (std::size_t b = part * together; b < std::min((part + 1) * together, blocks.size()); ++b) {
      if (!any_samples_near(view, blocks[b])) continue;
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

/// Lists the face in all tiles that the face or its samples may touch.
void SubpixelResolver::list_face(const PreparedView& view, FaceId face, TileLists::Part& list) {
  const FaceBounds bounds = widened(view.bounds(face));
  if (outside(bounds, view.camera.width, view.camera.height)) return;
  const PixelBox pixels = touched_pixels(bounds, view.frame());
  const std::int64_t tiles = grid_.touched(pixels);
  if (tiles > kMostTiles) {
    unlisted_.push_back(face);
    return;
  }
  const QuickFace quick = tiles > 4 ? view.quick(face, bounds) : QuickFace();
  grid_.for_each(pixels, quick, [&](std::size_t tile) {
    if (occupied_[tile] != 0) list.add(tile, face);
  });
}

void SubpixelResolver::add_samples(const PreparedView& view, std::size_t tile, FaceId face,
                                   SubpixelTile& samples) const {
  const SubpixelPositions at = subpixel_positions(view, face);
  const bool all = view.mask.everywhere() && tile_around(view.mesh.faces[index(face)]) == tile;
  for (std::size_t k = 0; k < kSubpixelSamples; ++k)
    if (all || (view.in_image(at.x[k], at.y[k]) && grid_.tile_of(at.x[k], at.y[k]) == tile))
      samples.add(face, at.x[k], at.y[k]);
}

void SubpixelResolver::fill(const PreparedView& view, std::span<const FaceCode> codes, std::size_t tile,
                            SubpixelTile& samples) const {
  samples.start();
  const std::span<const FaceId> faces = faces_by_tile_.of(tile);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    prefetch(view, faces, i);
    if (codes[index(faces[i])] == FaceCode::no_centre) add_samples(view, tile, faces[i], samples);
  }
  for (const FaceId face : unlisted_)
    if (codes[index(face)] == FaceCode::no_centre) add_samples(view, tile, face, samples);
  samples.sort();
}

void SubpixelResolver::count_visible(const SubpixelTile& samples) {
  samples.for_each_face([&](FaceId face, std::uint32_t visible, std::uint32_t all) {
    std::uint8_t& sum = visible_[index(face)];
    if (all == kSubpixelSamples) {  // all samples of the face lie in this tile
      sum = static_cast<std::uint8_t>(visible);
    } else {
      std::atomic_ref(sum).fetch_add(static_cast<std::uint8_t>(visible), std::memory_order_relaxed);
    }
  });
}

void SubpixelResolver::resolve_tiles(const PreparedView& view, std::span<const FaceCode> codes) {
  const std::vector<FaceId> unlisted(unlisted_.begin(), unlisted_.end());
  tbb::parallel_for(std::size_t{0}, tiles_.size(), [&](std::size_t i) {
    const std::span<const FaceId> faces = faces_by_tile_.of(tiles_[i]);
    if (faces.size() >= kFacesOfSharedTile) return;
    auto& [samples, found] = scratch_.local();
    fill(view, codes, tiles_[i], samples);
    samples.hide_behind(view, faces, found);
    samples.hide_behind(view, unlisted, found);
    count_visible(samples);
  });
  // Crowded tiles come one after the other: a thread that waits for an inner loop would start on another tile
  // meanwhile.
  SubpixelTile samples;
  for (const std::uint32_t tile : tiles_) {
    const std::span<const FaceId> faces = faces_by_tile_.of(tile);
    if (faces.size() < kFacesOfSharedTile) continue;
    fill(view, codes, tile, samples);
    const std::size_t parts = (faces.size() + kFacesAtOnce - 1) / kFacesAtOnce;
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
      const std::size_t first = part * kFacesAtOnce, count = std::min(kFacesAtOnce, faces.size() - first);
      samples.hide_behind(view, faces.subspan(first, count), scratch_.local().found);
    });
    samples.hide_behind(view, unlisted, scratch_.local().found);
    count_visible(samples);
  }
}

void SubpixelResolver::resolve(const PreparedView& view, std::span<const FaceCode> codes,
                               std::span<const PixelBox> blocks, std::size_t faces_per_block) {
  start(view);
  if (std::find(codes.begin(), codes.end(), FaceCode::no_centre) == codes.end()) return;
  find_vertex_tiles(view);
  find_tiles(view, codes);
  list_faces(view, blocks, faces_per_block);
  resolve_tiles(view, codes);
}

}  // namespace gpvc::visibility
