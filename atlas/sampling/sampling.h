// Colour of a photo at positions of its view's undistorted frame.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "atlas/sampling/color.h"
#include "atlas/sampling/layers.h"
#include "io/image.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// Catmull-Rom interpolation with repeated border pixels. May overshoot [0, 255]; store() clamps.
Color sample_bicubic(const Image& photo, double x, double y);

/// What interpolation gives: as it is, or kept between the four samples that the position lies among.
enum class Overshoot { kept, limited };
Color sample_bicubic(const Layer& photo, double x, double y, Overshoot overshoot);

/// Bilinear interpolation with repeated border pixels.
Color sample_bilinear(const Image& photo, double x, double y);
Color sample_bilinear(const Layer& photo, double x, double y);

/// Edge, in pixels, of squares within which photo_from_pixel may be interpolated bilinearly between the corners with an
/// error below kLatticeErrorPx; a power of two from 1 to 16. 16 for a camera without distortion, and about a pole, where
/// nothing is interpolated. Not counted is what it smooths of the shifts of aligned photos: they are known to a tenth of a
/// pixel.
int lattice_step(const Camera& camera);

/// Where neighbouring pixels differ by less than 100 grey levels, a shift by this changes a sample by less than one.
inline constexpr double kLatticeErrorPx = 0.01;

/// photo_from_pixel over a rectangle of the frame, interpolated between its corners.
class PhotoPositions {
 public:
  PhotoPositions(const Camera& camera, double x0, double y0, double x1, double y1);
  /// Not interpolated if a corner lies beyond the fold of the lens model, nor about a pole; nullopt if the position lies
  /// beyond the fold. \pre the position lies in the rectangle
  std::optional<PhotoPoint> at(double x, double y) const {
    if (!interpolated_) return photo_from_pixel(*camera_, {x, y});
    const double u = (x - x0_) * inverse_width_, v = (y - y0_) * inverse_height_;
    return PhotoPoint{lerp(lerp(corners_[0].x, corners_[1].x, u), lerp(corners_[2].x, corners_[3].x, u), v),
                      lerp(lerp(corners_[0].y, corners_[1].y, u), lerp(corners_[2].y, corners_[3].y, u), v)};
  }
  bool interpolated() const { return interpolated_; }
  /// Of the rectangle: (x0, y0), (x1, y0), (x0, y1), (x1, y1). \pre interpolated()
  const std::array<PhotoPoint, 4>& corners() const { return corners_; }

 private:
  static double lerp(double a, double b, double t) { return a + (b - a) * t; }
  const Camera* camera_;
  double x0_, y0_, inverse_width_, inverse_height_;
  std::array<PhotoPoint, 4> corners_;
  bool interpolated_;
};

/// A rectangle of a photo, for many bicubic samples: pixels as floats, four each, which fill a vector register.
class PhotoPatch {
 public:
  /// Takes what samples in the rectangle read.
  void load(const Image& photo, const PhotoPoint& low, const PhotoPoint& high);
  void load(const Layer& photo, const PhotoPoint& low, const PhotoPoint& high);

  /// Samples that are computed together.
  static constexpr std::size_t kRow = 8;
  /// Adds to `sums` what sample_bicubic gives at the positions first + i step. \pre they lie in the rectangle
  void add_row(const PhotoPoint& first, const PhotoPoint& step, std::span<Color, kRow> sums,
               Overshoot overshoot = Overshoot::kept) const;

 private:
  struct Axis {
    int first = 0, count = 0;  ///< pixels
    float low = 0, high = 0;   ///< range of sampled positions, from the centre of the first pixel
    Axis() = default;
    Axis(double from, double to, int size);
    double place(double position) const { return position - 0.5 - first; }
  };
  /// The first of the four pixels of each position along an axis, and their weights.
  struct Taps {
    std::array<int, kRow> first;
    std::array<std::array<float, kRow>, 4> weight;
    Taps(const Axis& axis, double from, double step);
  };
  template <typename Line>
  void load_lines(int width, int height, const PhotoPoint& low, const PhotoPoint& high, const Line& line);
  template <Overshoot kOvershoot>
  void add_row_with(const PhotoPoint& first, const PhotoPoint& step, std::span<Color, kRow> sums) const;

  Axis x_, y_;
  std::vector<float> pixels_;
};

}  // namespace gpvc::atlas
