// Faces whose projection contains no pixel centre: their samples are the centroid and the midpoints from it
// to the three vertices, and each is decided against every face that covers it, exactly.
//
// The samples are sorted by pixel, and within a crowded pixel by the cells of a grid as fine as it takes for
// about eight a cell. Every face of the mesh then visits the cells that its rectangle touches and hides the
// samples there that it covers and lies in front of. Marking commutes, so the result does not depend on the
// order. Cost: O(faces + pixels touched + pairs of a sample and a face in one cell).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify.h"

namespace gpvc {

inline constexpr std::size_t kSubpixelSamples = 4;

class SubpixelResolver {
 public:
  /// Decides all samples of `faces`: front faces without a pixel centre. `blocks` are the pixels that each
  /// `faces_per_block` consecutive faces of the mesh may touch. TBB.
  void resolve(const ClassifyView& view, std::span<const FaceId> faces, std::span<const PixelBox> blocks,
               std::size_t faces_per_block);
  /// How many of its samples see the `number`th face of the last resolve().
  std::uint32_t visible(std::size_t number) const;

 private:
  struct Sample {
    double x, y;
    std::uint32_t pixel;  ///< kNowhere when it is not in the image
    std::uint32_t at;     ///< its number in placed_; first its cell
  };
  /// A sample as the faces that pass over its cell meet it.
  struct Placed {
    FaceId face;
    std::uint32_t number;  ///< of the face among those to be resolved
  };
  struct Occluder;
  static constexpr std::uint32_t kNowhere = 0xFFFFFFFFU;

  void start(const ClassifyView& view, std::size_t faces);
  void make_samples(const ClassifyView& view, std::size_t number, FaceId face);
  void make_cells();
  void place(std::span<const FaceId> faces);
  template <class Callback>
  void for_each_occupied(Callback&& callback) const;
  bool any_in(const PixelBox& pixels) const;
  std::uint64_t occupied(std::size_t word, std::int32_t y, std::int32_t x0, std::int32_t x1) const;
  void hide_behind(const ClassifyView& view, FaceId face);
  void hide_in_row(Occluder& occluder, const FaceBounds& bounds, std::int32_t y);
  void hide_in_pixel(Occluder& occluder, const FaceBounds& bounds, std::int32_t x, std::int32_t y);
  void hide_in_cells(Occluder& occluder, const FaceBounds& bounds, std::size_t first, std::size_t last);
  void hide(Occluder& occluder, std::size_t at);
  void clear();

  QuickLimits limits_;
  std::vector<Sample> samples_;
  std::vector<DepthRange> depths_;          ///< of the faces to be resolved
  std::vector<Placed> placed_;              ///< by cell
  std::vector<double> x_, y_;               ///< where they lie, and a few more for reading four at a time
  std::vector<std::uint8_t> visible_;       ///< per placed sample
  std::vector<std::uint32_t> cell_end_;     ///< in placed_, of cells that follow one another
  std::vector<std::uint32_t> first_cell_;   ///< of a pixel; first the number of its samples
  std::vector<std::uint8_t> cells_a_side_;  ///< of a pixel
  std::vector<std::uint64_t> occupied_;     ///< a bit a pixel with samples, rows padded to whole words
  std::vector<std::uint8_t> tiles_;         ///< words of 64 rows with samples
  std::size_t stride_ = 0;                  ///< words a row
  int width_ = 0, height_ = 0;
};

}  // namespace gpvc
