// Faces whose projection contains no pixel centre: their samples are the centroid and the midpoints from it
// to the three vertices, and each is decided against every face that covers it, exactly.
//
// Samples and the faces that may hide them are sorted by tile of the image, and within a tile the samples by
// cell (SubpixelTile), so that what a thread works on stays near it. Every face of the mesh that may touch a
// tile with samples hides those of its samples that it covers and lies in front of. Marking commutes, so the
// result does not depend on the order. Cost: O(faces + tiles touched + pairs of a sample and a face in one
// row of cells).
#pragma once

#include <tbb/concurrent_vector.h>
#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify.h"
#include "visibility/subpixel_tile.h"

namespace gpvc {

inline constexpr std::size_t kSubpixelSamples = 4;

class SubpixelResolver {
 public:
  /// Decides all samples of `faces`: front faces without a pixel centre. `blocks` are the pixels that each
  /// `faces_per_block` consecutive faces of the mesh may touch. TBB.
  void resolve(const ClassifyView& view, std::span<const FaceId> faces, std::span<const PixelBox> blocks,
               std::size_t faces_per_block);
  /// How many of its samples see the `number`th face of the last resolve().
  std::uint32_t visible(std::size_t number) const { return visible_[number]; }

 private:
  /// Of one face; NaN where it is not in the image.
  struct Samples {
    std::array<double, kSubpixelSamples> x, y;
  };
  /// Numbers by tile: what blocks list at once, sorted by counting.
  class TileLists {
   public:
    /// What a block lists.
    class Block {
     public:
      void clear() { found_.clear(); }
      void add(std::uint32_t tile, std::uint32_t number) { found_.push_back({tile, number}); }

     private:
      friend class TileLists;
      struct Entry {
        std::uint32_t tile, number;
      };
      std::vector<Entry> found_;
    };

    /// Forgets everything.
    void start(std::size_t blocks, std::size_t tiles);
    Block& block(std::size_t number) { return blocks_[number]; }
    /// After all blocks have listed. The order within a tile depends on the threads. TBB.
    void sort();
    std::span<const std::uint32_t> of(std::size_t tile) const {
      const std::size_t first = tile == 0 ? 0 : end_[tile - 1];
      return std::span(numbers_).subspan(first, end_[tile] - first);
    }

   private:
    std::vector<Block> blocks_;
    std::vector<std::size_t> end_;  ///< of each tile in numbers_
    std::vector<std::uint32_t> numbers_;
  };

  void start(const ClassifyView& view, std::size_t faces);
  void make_samples(const ClassifyView& view, std::span<const FaceId> faces);
  void find_tiles();
  void list_occluders(const ClassifyView& view, std::span<const PixelBox> blocks,
                      std::size_t faces_per_block);
  void list_occluder(const ClassifyView& view, FaceId face, TileLists::Block& block);
  void resolve_tiles(const ClassifyView& view, std::span<const FaceId> faces);
  void fill(std::size_t tile, std::span<const FaceId> faces, SubpixelTile& samples) const;
  void count_visible(const SubpixelTile& samples);
  std::uint32_t tile_of(double x, double y) const;
  bool any_in(const PixelBox& pixels) const;

  QuickLimits limits_;
  int width_ = 0, height_ = 0;
  std::size_t tiles_across_ = 0, tiles_down_ = 0;
  std::vector<Samples> samples_;
  std::vector<std::uint8_t> visible_;
  TileLists samples_by_tile_, occluders_by_tile_;
  std::vector<std::uint32_t> tiles_;    ///< that hold samples
  std::vector<std::uint8_t> occupied_;  ///< per tile: whether it does
  std::vector<std::uint8_t> regions_;   ///< squares of tiles with one that does
  std::size_t regions_across_ = 0;
  tbb::concurrent_vector<FaceId> vast_;  ///< occluders of so many tiles that they are not listed
  struct Scratch {
    SubpixelTile tile;
    std::vector<std::uint32_t> found;
  };
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace gpvc
