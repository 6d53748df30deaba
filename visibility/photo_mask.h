// Which pixels of the undistorted frame show something of the photo.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/scene.h"

namespace gpvc {

/// One bit a pixel: its centre, distorted, lies in the photo.
class PhotoMask {
 public:
  PhotoMask() = default;
  /// O(pixels) at worst, TBB; nothing is stored for a camera without distortion.
  explicit PhotoMask(const Camera& camera);

  const Camera& camera() const { return camera_; }
  /// True when every pixel of the frame is in the photo.
  bool whole() const { return words_.empty(); }
  /// \pre the pixel is on the frame
  bool contains(int x, int y) const {
    if (whole()) return true;
    const auto column = static_cast<std::size_t>(x);
    return (words_[static_cast<std::size_t>(y) * stride_ + column / 64] >> (column % 64)) & 1U;
  }
  /// 64 pixels a word, stride() words a row; empty when whole().
  std::span<const std::uint64_t> words() const { return words_; }
  std::size_t stride() const { return stride_; }
  /// Sets the entries of a row-major item buffer outside the photo to kNoFace. TBB.
  void clear_outside(std::vector<FaceId>& faces) const;

 private:
  void fill_block(int x0, int y0, int x1, int y1);

  Camera camera_;
  std::size_t stride_ = 0;  ///< words a row
  std::vector<std::uint64_t> words_;
};

}  // namespace gpvc
