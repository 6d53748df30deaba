// The frame of a view in squares of a few pixels: what the photo shows there, and whether the mesh is there.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/image.h"
#include "io/photos.h"
#include "io/scene.h"
#include "visibility/result.h"

namespace gpvc::labeling {

/// Edge of a cell in pixels: the mean over it has a quarter of a pixel's noise. The last cells of rows and columns may be smaller.
inline constexpr int kFrameCell = 4;

struct FrameCell {
  std::array<float, 3> mean{};  ///< R, G, B in grey levels
  float spread = 0;             ///< standard deviation of the pixels' brightness, in grey levels
  std::uint8_t faces = 0;       ///< pixels of the photo that show a face
  std::uint8_t bare = 0;        ///< and those that show none
  bool is_whole = false;        ///< none of its pixels lies outside the photo or is excluded
  bool is_bare() const { return is_whole && faces == 0; }
};

/// The pixels x0 .. x1 - 1 of the rows y0 .. y1 - 1.
struct CellBox {
  int x0, y0, x1, y1;
};

/// The channel in which two colours differ most, in grey levels.
float distance(const std::array<float, 3>& a, const std::array<float, 3>& b);

/// Row-major.
struct FrameCells {
  int width = 0, height = 0;  ///< of the frame, in pixels
  int columns = 0, rows = 0;
  std::vector<FrameCell> cells;

  std::size_t index_of(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
  }
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < columns && y < rows; }
  const FrameCell& at(int x, int y) const { return cells[index_of(x, y)]; }
  CellBox box(int x, int y) const {
    return {x * kFrameCell, y * kFrameCell, std::min((x + 1) * kFrameCell, width),
            std::min((y + 1) * kFrameCell, height)};
  }

  /// Keeps the memory. \param excluded may be null. O(pixels), TBB.
  void fill(const Camera& camera, const Image& photo, const io::PhotoExclusion* excluded, const visibility::Ivm& ivm);
};

}  // namespace gpvc::labeling
