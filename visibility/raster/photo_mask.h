// Which pixels of the undistorted frame show a usable part of the photo.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/photos.h"
#include "io/scene.h"

namespace gpvc::visibility {

/// True when a position of the frame, distorted, lies in the photo and not on an excluded pixel. `excluded`: null for none.
bool shows(const Camera& camera, const io::PhotoExclusion* excluded, const PixelPoint& position);

/// One bit a pixel: set when its centre, distorted, lies in the photo and not on an excluded pixel.
class PhotoMask {
 public:
  PhotoMask() = default;
  /// O(pixels) at worst, TBB; nothing is stored for a camera without distortion.
  explicit PhotoMask(const Camera& camera);
  /// The lens mask without the excluded pixels; borrows `exclusion`, which has the camera's size. O(pixels), TBB.
  PhotoMask(const PhotoMask& lens, const io::PhotoExclusion& exclusion);

  /// An identifier: masks with the same number are equal.
  std::uint64_t number() const { return number_; }
  const Camera& camera() const { return camera_; }
  /// True when every pixel of the frame is in the photo.
  bool whole() const { return words_.empty(); }
  /// \pre the pixel is on the frame
  bool contains(int x, int y) const {
    if (whole()) return true;
    const auto column = static_cast<std::size_t>(x);
    return (words_[static_cast<std::size_t>(y) * stride_ + column / 64] >> (column % 64)) & 1U;
  }
  /// True when every position of the frame is in the photo, including those nearer to its border than any pixel centre.
  bool everywhere() const { return everywhere_; }
  /// True when a subpixel position of the frame, distorted, lies in the photo and not on an excluded pixel.
  bool contains(const PixelPoint& position) const;
  /// 64 pixels a word, stride() words a row; empty when whole().
  std::span<const std::uint64_t> words() const { return words_; }
  std::size_t stride() const { return stride_; }
  /// Sets the entries of a row-major item buffer outside the photo to kNoFace. TBB.
  void clear_outside(std::vector<FaceId>& faces) const;

 private:
  void fill_block(int x0, int y0, int x1, int y1);
  /// The word that holds a pixel.
  std::uint64_t& word(int x, int y) {
    return words_[static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x) / 64];
  }

  Camera camera_;
  const io::PhotoExclusion* exclusion_ = nullptr;
  bool everywhere_ = true;
  std::uint64_t number_ = 0;
  std::size_t stride_ = 0;  ///< words a row
  std::vector<std::uint64_t> words_;
};

}  // namespace gpvc::visibility
