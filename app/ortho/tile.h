// Draws a part of an orthophoto.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "app/ortho/grid.h"
#include "app/ortho/page_store.h"
#include "app/ortho/surface.h"

namespace gpvc::ortho {

/// Half-open, in pixels of the orthophoto.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Some rows of an orthophoto.
struct Rows {
  int first = 0, width = 0;
  std::vector<std::uint8_t> rgb, mask;  ///< mask: 255 where at least half of the pixel shows textured faces, else 0
  std::vector<std::uint32_t>
      photo;  ///< of the textured sample next to the pixel's middle; kNoPhoto where the mask is 0
  std::vector<float>
      height;  ///< of the sample next to the pixel's middle; kNoHeight where the mesh covers less than half of it

  std::size_t bands = 0;       ///< of the pages' samples; 0: they have none
  std::vector<float> samples;  ///< of each pixel and band the mean, as `rgb`; 0 where the mask is 0

  void reset(int first_row, int rows, int row_width, std::size_t band_count);
};

/// Vertices on the plane of the picture, in sixteenths of the samples' distance, y down.
struct PlanPoint {
  std::int32_t x = 0, y = 0;
};
inline constexpr int kPlanUnit = 16;
/// The corners of all faces, the same for all tiles: so neighbouring faces and tiles leave no gap and overlap nowhere. Throws
/// InputError where the mesh reaches further than 2^30 units from the picture's corner.
std::vector<PlanPoint> plan_points(const Surface& surface, const Grid& grid);

/// What tiles are drawn from. Borrows all.
struct Drawing {
  const Surface& surface;
  const PageStore& pages;
  const Grid& grid;
  const std::vector<PlanPoint>& plan;
};

/// Draws one tile after the other. Each sample shows the highest face over it, of those at one height the first; each pixel the mean of
/// its textured samples.
class TileRenderer {
 public:
  explicit TileRenderer(const Drawing& drawing);
  /// \param faces ascending, all that may lie in the box. Writes the box into `rows`. O(faces + samples)
  void draw(const PixelBox& box, std::span<const std::uint32_t> faces, Rows& rows);

 private:
  struct Sample {
    float height;
    std::uint32_t face;
  };
  void draw_face(std::uint32_t face);
  void add_colors();
  void write_pixels(Rows& rows) const;
  std::size_t sample_index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }

  const Drawing& of_;
  std::vector<std::array<int, 2>> from_middle_;  ///< samples of a pixel, those next to its middle first
  PixelBox box_;
  int columns_ = 0, rows_ = 0;  ///< samples of the tile
  std::vector<Sample> samples_;
  struct Pixel {
    std::array<float, 3> color;
    int textured, covered;  ///< samples
  };
  std::vector<Pixel> pixels_;
  std::size_t bands_;
  std::vector<float> band_sums_;  ///< per pixel and band, of the textured samples
};

}  // namespace gpvc::ortho
