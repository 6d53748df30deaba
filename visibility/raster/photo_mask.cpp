#include "visibility/raster/photo_mask.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace gpvc::visibility {
namespace {

/// Blocks are one word wide, so that no two tasks write the same word.
constexpr int kBlock = 64;

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

/// A word whose first `count` bits are set, or all 64 of them. \pre count > 0
std::uint64_t first_bits(int count) { return ~std::uint64_t{0} >> (64 - std::min(count, 64)); }

/// \pre the point lies in the photo
bool is_excluded(const io::PhotoExclusion& exclusion, const PhotoPoint& p) {
  return exclusion.excludes(std::min(static_cast<int>(p.x), exclusion.width - 1),
                            std::min(static_cast<int>(p.y), exclusion.height - 1));
}

}  // namespace

PhotoMask::PhotoMask(const PhotoMask& lens, const io::PhotoExclusion& exclusion)
    : camera_(lens.camera_),
      exclusion_(&exclusion),
      everywhere_(false),
      number_(next_number()),
      stride_((static_cast<std::size_t>(lens.camera_.width) + 63) / 64) {
  words_.assign(stride_ * static_cast<std::size_t>(camera_.height), 0);
  tbb::parallel_for(0, camera_.height, [&](int y) {
    for (int x = 0; x < camera_.width; ++x)
      if (lens.contains(x, y) && contains(PixelPoint{x + 0.5, y + 0.5})) word(x, y) |= std::uint64_t{1} << (x % 64);
  });
}

bool shows(const Camera& camera, const io::PhotoExclusion* excluded, const PixelPoint& position) {
  const std::optional<PhotoPoint> photo = photo_from_pixel(camera, position);
  if (!photo || !(photo->x >= 0 && photo->y >= 0 && photo->x <= camera.width && photo->y <= camera.height))
    return false;
  return excluded == nullptr || !is_excluded(*excluded, *photo);
}

bool PhotoMask::contains(const PixelPoint& position) const {
  return everywhere() || shows(camera_, exclusion_, position);
}

PhotoMask::PhotoMask(const Camera& camera) : camera_(camera), number_(next_number()) {
  if (camera.distortion.is_identity()) return;
  everywhere_ = false;
  stride_ = (static_cast<std::size_t>(camera.width) + 63) / 64;
  words_.assign(stride_ * static_cast<std::size_t>(camera.height), 0);
  const int columns = (camera.width + kBlock - 1) / kBlock, rows = (camera.height + kBlock - 1) / kBlock;
  tbb::parallel_for(0, rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      fill_block(column * kBlock, row * kBlock, std::min((column + 1) * kBlock, camera.width),
                 std::min((row + 1) * kBlock, camera.height));
    }
  });
  bool whole = true;
  for (int y = 0; y < camera.height && whole; ++y)
    for (int x = 0; x < camera.width && whole; x += kBlock) whole = word(x, y) == first_bits(camera.width - x);
  if (whole) words_.clear();
}

void PhotoMask::fill_block(int x0, int y0, int x1, int y1) {
  // When the middle of the block lies further inside the photo than the distortion can stretch half a diagonal, all of
  // it is inside, unless the model folds back within the block.
  const PixelPoint middle{0.5 * (x0 + x1), 0.5 * (y0 + y1)};
  const double reach = 0.5 * std::hypot(x1 - x0, y1 - y0);
  const double nx = (std::abs(middle.x - camera_.cx) + reach) / camera_.fx;
  const double ny = (std::abs(middle.y - camera_.cy) + reach) / camera_.fy;
  const double r2 = nx * nx + ny * ny;
  if (r2 < camera_.distortion.max_r2) {
    if (const std::optional<PhotoPoint> photo = photo_from_pixel(camera_, middle)) {
      const double margin = largest_stretch(camera_, r2) * reach;
      if (photo->x > margin && photo->y > margin && photo->x < camera_.width - margin &&
          photo->y < camera_.height - margin) {
        for (int y = y0; y < y1; ++y) word(x0, y) = first_bits(x1 - x0);
        return;
      }
    }
  }
  for (int y = y0; y < y1; ++y) {
    std::uint64_t bits = 0;
    for (int x = x0; x < x1; ++x)
      if (in_photo(camera_, {x + 0.5, y + 0.5})) bits |= std::uint64_t{1} << (x - x0);
    word(x0, y) = bits;
  }
}

void PhotoMask::clear_outside(std::vector<FaceId>& faces) const {
  if (whole()) return;
  const auto width = static_cast<std::size_t>(camera_.width);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, static_cast<std::size_t>(camera_.height), 16),
                    [&](const tbb::blocked_range<std::size_t>& rows) {
                      for (std::size_t y = rows.begin(); y != rows.end(); ++y)
                        for (std::size_t word = 0; word < stride_; ++word) {
                          std::uint64_t outside = ~words_[y * stride_ + word];
                          if (outside == 0) continue;
                          const std::size_t count = std::min<std::size_t>(64, width - word * 64);
                          FaceId* first = faces.data() + y * width + word * 64;
                          for (std::size_t bit = 0; bit < count; ++bit, outside >>= 1)
                            if (outside & 1U) first[bit] = kNoFace;
                        }
                    });
}

}  // namespace gpvc::visibility
