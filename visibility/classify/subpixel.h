// Faces whose projection contains no pixel centre: their samples are the centroid and the midpoints from it to the
// three vertices, and each is decided against every face that covers it, exactly.
//
// Faces are sorted by tile of the image, and within a tile samples by cell (SubpixelTile), so that a thread works on
// memory that is close together. Every face of the mesh that may touch a tile with samples hides those of its samples
// that it covers and lies in front of. Marking a sample hidden commutes, so the result does not depend on the order.
// Cost: O(vertices + faces + tiles touched + pairs of a sample and a face in one row of cells).
#pragma once

#include <tbb/concurrent_vector.h>
#include <tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify/face_scan.h"
#include "visibility/classify/subpixel_tile.h"
#include "visibility/raster/tile_lists.h"

namespace gpvc::visibility {

class SubpixelResolver {
 public:
  /// Decides all samples of the faces with the code no_centre, which must be front faces. `blocks` are the pixels that
  /// each `faces_per_block` consecutive faces of the mesh may touch. TBB.
  void resolve(const PreparedView& view, std::span<const FaceCode> codes, std::span<const PixelBox> blocks,
               std::size_t faces_per_block);
  /// How many of the samples of such a face of the last resolve() see it.
  std::uint32_t visible(FaceId face) const { return visible_[index(face)]; }

 private:
  struct Scratch {
    SubpixelTile tile;
    SubpixelTile::Found found;
  };

  void start(const PreparedView& view);
  void find_vertex_tiles(const PreparedView& view);
  void find_tiles(const PreparedView& view, std::span<const FaceCode> codes);
  void occupy(std::size_t tile);
  void list_faces(const PreparedView& view, std::span<const PixelBox> blocks, std::size_t faces_per_block);
  void list_face(const PreparedView& view, FaceId face, TileLists::Part& list);
  void resolve_tiles(const PreparedView& view, std::span<const FaceCode> codes);
  void fill(const PreparedView& view, std::span<const FaceCode> codes, std::size_t tile, SubpixelTile& samples) const;
  void add_samples(const PreparedView& view, std::size_t tile, FaceId face, SubpixelTile& samples) const;
  void count_visible(const SubpixelTile& samples);
  std::uint32_t tile_around(const Triangle& face) const;
  bool any_samples_near(const PreparedView& view, const PixelBox& pixels) const;

  TileGrid grid_, regions_;                  ///< regions: squares of tiles
  std::vector<std::uint32_t> vertex_tiles_;  ///< the tile of each vertex, where it is certain
  std::vector<std::uint8_t> visible_;        ///< per face
  TileLists faces_by_tile_;
  std::vector<std::uint32_t> tiles_;                       ///< tiles with samples
  std::vector<std::uint8_t> occupied_, occupied_regions_;  ///< per tile and region: 1 where it has samples
  tbb::concurrent_vector<FaceId> unlisted_;                ///< faces that touch too many tiles to be listed
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace gpvc::visibility
