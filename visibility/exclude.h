// Takes pixels away from what a view sees, once its photo has told that they show something else than the mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "../io/scene.h"
#include "result.h"

namespace gpvc::visibility {

/// Pixels of a frame, a bit for each.
class PixelSet {
 public:
  PixelSet() = default;
  /// Empty.
  PixelSet(int width, int height)
      : stride_((static_cast<std::size_t>(width) + 63) / 64), words_(stride_ * static_cast<std::size_t>(height), 0) {}
  bool contains(int x, int y) const { return (words_[word(x, y)] >> (x % 64)) & 1U; }
  void add(int x, int y) { words_[word(x, y)] |= std::uint64_t{1} << (x % 64); }

 private:
  std::size_t word(int x, int y) const {
    return static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x) / 64;
  }
  std::size_t stride_ = 0;
  std::vector<std::uint64_t> words_;
};

/// Pixels of a photo that show something else than the mesh; all sets are of the frame's size.
struct ExcludedPixels {
  PixelSet all;
  PixelSet background;  ///< those of them that show for certain what lies behind
  PixelSet mixed;       ///< those that are mixed with it
};

/// As if a mask had excluded the pixels, which become kNoFace in the IVM. Faces that lose some of their pixels are partial; the
/// share that is visible falls with their number. Faces that lose all are FaceClass::background if at least half of them show
/// background, else mixed if half of them show background or a mixture, else hidden; so are faces without pixels, by the pixels
/// that hold their centroids. \param excluded of the IVM's size, in which `id` was seen \return how many of the pixels showed a
/// face. O(pixels + faces).
std::size_t exclude(const Mesh& mesh, const View& view, ViewId id, const ExcludedPixels& excluded,
                    ViewVisibility& seen);

}  // namespace gpvc::visibility
