// Faces whose projection contains no pixel centre: their samples are the centroid and the midpoints from it
// to the three vertices, and each is decided against every face that covers it, exactly.
//
// The samples are sorted by pixel. Every face of the mesh then visits the pixels its projection
// touches and hides the samples there that it covers and lies in front of. Marking commutes, so the result
// does not depend on the order. Cost: O(faces + pixels touched + pairs of a sample and a face in one pixel).
#pragma once

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
    FaceId face;
    std::uint32_t pixel;  ///< kNoPixel when it is not in the image
  };
  /// A sample as the faces that pass over its pixel meet it.
  struct Placed {
    float x, y;  ///< rounded
    std::uint32_t sample, pixel;
  };
  static constexpr std::uint32_t kNoPixel = 0xFFFFFFFFU;

  void start(const ClassifyView& view, std::size_t faces);
  void place(const ClassifyView& view, std::size_t number, FaceId face);
  void sort_by_pixel();
  template <class Callback>
  void for_each_occupied(Callback&& callback) const;
  bool any_in(const PixelBox& pixels) const;
  void hide_behind(const ClassifyView& view, FaceId face);
  void hide_in_pixel(const ClassifyView& view, FaceId face, const RasterFace& raster,
                     const FaceBounds& bounds, std::size_t pixel);

  std::vector<Sample> samples_;
  std::vector<std::uint8_t> visible_;    ///< per sample
  std::vector<Placed> placed_;           ///< by pixel
  std::vector<std::uint32_t> end_;       ///< of each pixel's samples in placed_; 0 where there are none
  std::vector<std::uint64_t> occupied_;  ///< a bit a pixel with samples, rows padded to whole words
  std::vector<std::uint8_t> tiles_;      ///< words of 64 rows with samples
  std::size_t stride_ = 0;               ///< words a row
  int width_ = 0, height_ = 0;
};

}  // namespace gpvc
