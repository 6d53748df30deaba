#include "labeling/background/frame_cells.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "labeling/costs/photo_lookup.h"

namespace gpvc::labeling {
namespace {

/// Sums over a cell's pixels.
struct CellSums {
  std::array<std::uint32_t, 3> rgb{};
  std::uint32_t squares = 0;  ///< of R + 2 G + B, at most 16 * 1020^2
  std::uint8_t faces = 0, bare = 0;

  void add(const std::uint8_t* pixel, FaceId face) {
    for (std::size_t c = 0; c < 3; ++c) rgb[c] += pixel[c];
    const std::uint32_t brightness = pixel[0] + 2U * pixel[1] + pixel[2];
    squares += brightness * brightness;
    const bool is_bare = face == kNoFace;
    bare = static_cast<std::uint8_t>(bare + is_bare);
    faces = static_cast<std::uint8_t>(faces + !is_bare);
  }
  FrameCell cell(int pixels) const {
    FrameCell cell{{}, 0, faces, bare, faces + bare == pixels};
    const auto count = static_cast<float>(faces + bare);
    if (count == 0) return cell;
    for (std::size_t c = 0; c < 3; ++c) cell.mean[c] = static_cast<float>(rgb[c]) / count;
    const float brightness = cell.mean[0] + 2 * cell.mean[1] + cell.mean[2];
    cell.spread = std::sqrt(std::max(0.0F, static_cast<float>(squares) / count - brightness * brightness)) / 4;
    return cell;
  }
};

/// Tells which pixels of a photo can be looked at.
class Looked {
 public:
  Looked(const Camera& camera, const io::PhotoExclusion* excluded)
      : width_(camera.width),
        height_(camera.height),
        is_clamped_(!camera.distortion.is_identity()),
        excluded_(excluded) {}
  /// PhotoLookup gives the outermost pixels for all that lies beyond them.
  bool at(std::uint32_t pixel) const {
    if (pixel == PhotoLookup::kNoPixel) return false;
    if (!is_clamped_ && excluded_ == nullptr) return true;
    const auto width = static_cast<std::uint32_t>(width_);
    const auto x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
    if (is_clamped_ && (x == 0 || y == 0 || x == width_ - 1 || y == height_ - 1)) return false;
    return excluded_ == nullptr || !excluded_->excludes(x, y);
  }
  /// Whether at() is true of all pixels, which then are the frame's own.
  bool all() const { return !is_clamped_ && excluded_ == nullptr; }

 private:
  int width_, height_;
  bool is_clamped_;
  const io::PhotoExclusion* excluded_;
};

}  // namespace

float distance(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

void FrameCells::fill(const Camera& camera, const Image& photo, const io::PhotoExclusion* excluded,
                      const visibility::Ivm& ivm) {
  width = camera.width;
  height = camera.height;
  columns = (width + kFrameCell - 1) / kFrameCell;
  rows = (height + kFrameCell - 1) / kFrameCell;
  cells.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const PhotoLookup lookup(camera);
  const Looked looked(camera, excluded);
  tbb::parallel_for(tbb::blocked_range<int>(0, rows, 8), [&](const tbb::blocked_range<int>& range) {
    std::vector<std::uint32_t> photo_pixels;
    std::vector<CellSums> sums;
    for (int row = range.begin(); row != range.end(); ++row) {
      sums.assign(static_cast<std::size_t>(columns), {});
      for (int y = row * kFrameCell; y < std::min((row + 1) * kFrameCell, height); ++y) {
        const FaceId* face = ivm.faces.data() + pixel_index(0, y, width);
        if (looked.all()) {
          const std::uint8_t* rgb = photo.at(0, y);
          for (int x = 0; x < width; x += kFrameCell) {
            CellSums sum = sums[static_cast<std::size_t>(x / kFrameCell)];
            for (int i = x; i < std::min(x + kFrameCell, width); ++i, rgb += 3, ++face) sum.add(rgb, *face);
            sums[static_cast<std::size_t>(x / kFrameCell)] = sum;
          }
          continue;
        }
        lookup.find_row(y, photo_pixels);
        for (int x = 0; x < width; ++x)
          if (const std::uint32_t pixel = photo_pixels[static_cast<std::size_t>(x)]; looked.at(pixel))
            sums[static_cast<std::size_t>(x / kFrameCell)].add(photo.pixels.data() + 3 * std::size_t{pixel}, face[x]);
      }
      for (int x = 0; x < columns; ++x) {
        const CellBox pixels = box(x, row);
        cells[index_of(x, row)] =
            sums[static_cast<std::size_t>(x)].cell((pixels.x1 - pixels.x0) * (pixels.y1 - pixels.y0));
      }
    }
  });
}

}  // namespace gpvc::labeling
