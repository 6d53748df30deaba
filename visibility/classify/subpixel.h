// Faces whose projection contains no pixel centre: their samples are the centroid and the midpoints from it to the
// three vertices, and each is decided against every face that covers it, exactly.
//
// Faces are sorted by tile of the image, and within a tile samples by cell (SubpixelTile), so that what a thread works
// on stays near it. Every face of the mesh that may touch a tile with samples hides those of its samples that it covers
// and lies in front of. Marking commutes, so the result does not depend on the order. Cost: O(vertices + faces + tiles
// touched + pairs of a sample and a face in one row of cells).
#pragma once

#include <tbb/concurrent_vector.h>
#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/classify/subpixel_tile.h"
#include "visibility/raster/tile_lists.h"

namespace gpvc::visibility {

class SubpixelResolver {
 public:
  /// Decides all samples of the faces with the code no_centre, which must be front faces. `blocks` are the pixels that
  /// each `faces_per_block` consecutive faces of the mesh may touch. TBB.
  void resolve(const ClassifyView& view, std::span<const FaceCode> codes, std::span<const PixelBox> blocks,
               std::size_t faces_per_block);
  /// How many of the samples of such a face of the last resolve() see it.
  std::uint32_t visible(FaceId face) const { return visible_[index(face)]; }

 private:
  struct Scratch {
    SubpixelTile tile;
    SubpixelTile::Found found;
  };

  void start(const ClassifyView& view);
  void find_vertex_tiles(const ClassifyView& view);
  void find_tiles(const ClassifyView& view, std::span<const FaceCode> codes);
  void occupy(std::size_t tile);
  void list_faces(const ClassifyView& view, std::span<const PixelBox> blocks, std::size_t faces_per_block);
  void list_face(const ClassifyView& view, FaceId face, TileLists::Part& list);
  void resolve_tiles(const ClassifyView& view, std::span<const FaceCode> codes);
  void fill(const ClassifyView& view, std::span<const FaceCode> codes, std::size_t tile, SubpixelTile& samples) const;
  void add_samples(const ClassifyView& view, std::size_t tile, FaceId face, SubpixelTile& samples) const;
  void count_visible(const SubpixelTile& samples);
  std::uint32_t tile_of(double x, double y) const;
  std::uint32_t tile_around(const Triangle& face) const;
  bool any_in(const PixelBox& pixels) const;

  QuickLimits limits_;
  int width_ = 0, height_ = 0;
  TileGrid grid_;
  std::vector<std::uint32_t> vertex_tiles_;  ///< the tile of each vertex, where it is certain
  std::vector<std::uint8_t> visible_;        ///< per face
  TileLists faces_by_tile_;
  std::vector<std::uint32_t> tiles_;    ///< that hold samples
  std::vector<std::uint8_t> occupied_;  ///< per tile: whether it does
  std::vector<std::uint8_t> regions_;   ///< squares of tiles with one that does
  std::size_t regions_across_ = 0;
  tbb::concurrent_vector<FaceId> vast_;  ///< faces of so many tiles that they are not listed
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace gpvc::visibility
