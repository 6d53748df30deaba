#include "atlas/alignment/patch.h"

#include <algorithm>
#include <cmath>

#include "atlas/sampling/sampling.h"
#include "io/photos.h"
#include "io/vector.h"
#include "io/wide_clones.h"

namespace gpvc::atlas {

namespace {

constexpr std::size_t kSamples = kPatchWindow * kPatchWindow;
constexpr std::size_t kShifts = 2 * kPatchReach + 1;
/// Below this photos are taken to show different things.
constexpr double kLeastCorrelation = 0.7;

using Window = std::array<float, kSamples>;

constexpr std::size_t kLanes = 8;
/// Sums of eighths, which a processor adds side by side.
template <class Value>
float sum_of(const Value& value) {
  std::array<float, kLanes> sums{};
  for (std::size_t i = 0; i < kSamples; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) sums[k] += value(i + k);
  float sum = 0;
  for (const float part : sums) sum += part;
  return sum;
}

float product(const Window& a, const Window& b) {
  return sum_of([&](std::size_t i) { return a[i] * b[i]; });
}

/// Takes the mean off, and returns the length of what is left.
float center(Window& window) {
  const float mean = sum_of([&](std::size_t i) { return window[i]; }) / kSamples;
  for (float& value : window) value -= mean;
  return std::sqrt(product(window, window));
}

/// The samples from a whole number of samples (column, row) on.
Window window_at(const Patch& patch, std::size_t column, std::size_t row) {
  Window window;
  for (std::size_t y = 0; y < kPatchWindow; ++y)
    for (std::size_t x = 0; x < kPatchWindow; ++x)
      window[y * kPatchWindow + x] = static_cast<float>(patch.luma[(row + y) * kPatchEdge + column + x]);
  return window;
}

/// As above, between samples. \pre 0 <= column, row <= 2 kPatchReach
Window window_between(const Patch& patch, double column, double row) {
  constexpr std::size_t kLast = kPatchEdge - kPatchWindow - 1;
  const std::size_t x0 = std::min(static_cast<std::size_t>(column), kLast);
  const std::size_t y0 = std::min(static_cast<std::size_t>(row), kLast);
  const auto fx = static_cast<float>(column - static_cast<double>(x0));
  const auto fy = static_cast<float>(row - static_cast<double>(y0));
  Window window;
  for (std::size_t y = 0; y < kPatchWindow; ++y) {
    const std::uint8_t* upper = patch.luma.data() + (y0 + y) * kPatchEdge + x0;
    for (std::size_t x = 0; x < kPatchWindow; ++x) {
      const std::uint8_t* at = upper + x;
      const auto a = static_cast<float>(at[0]), b = static_cast<float>(at[1]);
      const auto c = static_cast<float>(at[kPatchEdge]), d = static_cast<float>(at[kPatchEdge + 1]);
      const float top = a + fx * (b - a), bottom = c + fx * (d - c);
      window[y * kPatchWindow + x] = top + fy * (bottom - top);
    }
  }
  return window;
}

/// The middle of a patch, and what its brightness changes by if it is moved, as far as a gain and an offset do not explain it.
struct Template {
  explicit Template(const Patch& patch) : middle(window_at(patch, kPatchReach, kPatchReach)), norm(center(middle)) {
    for (std::size_t y = 0; y < kPatchWindow; ++y) {
      for (std::size_t x = 0; x < kPatchWindow; ++x) {
        const std::size_t at = (kPatchReach + y) * kPatchEdge + kPatchReach + x;
        const auto level = [&](std::size_t sample) { return static_cast<float>(patch.luma[sample]); };
        along_x[y * kPatchWindow + x] = (level(at + 1) - level(at - 1)) / 2;
        along_y[y * kPatchWindow + x] = (level(at + kPatchEdge) - level(at - kPatchEdge)) / 2;
      }
    }
    for (Window* gradient : {&along_x, &along_y}) {
      center(*gradient);
      if (norm == 0) continue;
      const float share = product(*gradient, middle) / (norm * norm);
      for (std::size_t i = 0; i < kSamples; ++i) (*gradient)[i] -= share * middle[i];
    }
    xx = double{product(along_x, along_x)};
    xy = double{product(along_x, along_y)};
    yy = double{product(along_y, along_y)};
  }
  /// What moving it by (x, y) samples takes from its correlation with itself, to second order.
  double loss(double x, double y) const {
    return (xx * x * x + 2 * xy * x * y + yy * y * y) / (2 * double{norm} * double{norm});
  }

  Window middle, along_x, along_y;  ///< without their means
  float norm;
  double xx = 0, xy = 0, yy = 0;  ///< squared grey levels, per squared sample
};

double largest_eigenvalue(double xx, double xy, double yy) { return (xx + yy) / 2 + std::hypot((xx - yy) / 2, xy); }

/// By whole samples, to the window that correlates best.
struct WholeShift {
  std::size_t column = 0, row = 0;
  double correlation = -1;
};

/// nullopt where the best lies at the end of the reach, or where another one is nearly as good and not because there is an edge
/// alone.
std::optional<WholeShift> best_whole_shift(const Template& reference, const Patch& other) {
  // Whole numbers are added side by side in any order. A product is below 2^20, a sum of them below 2^28.
  constexpr float kUnit = 16;
  std::array<std::int16_t, kSamples> middle;
  for (std::size_t i = 0; i < kSamples; ++i)
    middle[i] = static_cast<std::int16_t>(std::lround(kUnit * reference.middle[i]));
  std::array<double, kShifts * kShifts> correlations{};
  WholeShift best;
  for (std::size_t row = 0; row < kShifts; ++row) {
    for (std::size_t column = 0; column < kShifts; ++column) {
      std::int32_t sum = 0, squares = 0, both = 0;
      for (std::size_t y = 0; y < kPatchWindow; ++y) {
        const std::uint8_t* levels = other.luma.data() + (row + y) * kPatchEdge + column;
        const std::int16_t* mine = middle.data() + y * kPatchWindow;
        for (std::size_t x = 0; x < kPatchWindow; ++x) {
          const std::int16_t level = levels[x];
          sum += level;
          squares += level * level;
          both += level * mine[x];
        }
      }
      const double norm2 = squares - double{1} * sum * sum / kSamples;
      correlations[row * kShifts + column] =
          norm2 > 1 ? both / (double{kUnit} * double{reference.norm} * std::sqrt(norm2)) : 0;
    }
  }
  // Along an edge all shifts are equally good: of those the nearest.
  double most = -1;
  for (std::size_t row = 0; row < kShifts; ++row) {
    for (std::size_t column = 0; column < kShifts; ++column) {
      constexpr double kPreference = 1e-3;
      const double x = static_cast<double>(column) - kPatchReach, y = static_cast<double>(row) - kPatchReach;
      const double correlation = correlations[row * kShifts + column],
                   value = correlation - kPreference * (x * x + y * y);
      if (value <= most) continue;
      most = value;
      best = {column, row, correlation};
    }
  }
  if (best.column == 0 || best.row == 0 || best.column == kShifts - 1 || best.row == kShifts - 1) return std::nullopt;
  // Of texture that repeats the loss would be far greater than it is.
  constexpr double kDistinct = 0.05, kFarLess = 4;
  for (std::size_t row = 0; row < kShifts; ++row) {
    for (std::size_t column = 0; column < kShifts; ++column) {
      const double x = static_cast<double>(column) - static_cast<double>(best.column);
      const double y = static_cast<double>(row) - static_cast<double>(best.row);
      if (std::max(std::abs(x), std::abs(y)) < 2) continue;
      const bool is_near = best.correlation - correlations[row * kShifts + column] < kDistinct;
      if (is_near && reference.loss(x, y) > kFarLess * kDistinct) return std::nullopt;
    }
  }
  return best;
}

/// Where a view's photo has the points of a grid.
class GridPositions {
 public:
  GridPositions(const View& reference, const View& view, const SurfacePlace& place, const GridDepths& depths)
      : camera_(view.camera), depths_(depths) {
    const WorldPoint ray = ray_of(reference, grid_position(place, 0, 0));
    shift_ = to_camera_axes(view.pose, reference.pose.centre - view.pose.centre);
    first_ = to_camera_axes(view.pose, ray);
    column_ = to_camera_axes(view.pose, ray_of(reference, grid_position(place, 1, 0)) - ray);
    row_ = to_camera_axes(view.pose, ray_of(reference, grid_position(place, 0, 1)) - ray);
    set_lens();
  }

  /// In the photo; nullopt behind the camera, and beyond the lens.
  std::optional<PhotoPoint> at(std::size_t point) const {
    const CameraPoint p = camera_point(point);
    if (!(p.z > 0)) return std::nullopt;
    const PixelPoint q = pixel_from_camera(camera_, p);
    const double x = q.x - middle_.x, y = q.y - middle_.y;
    // A lens bends so little within some 60 pixels that its error is a few hundredths of a pixel.
    constexpr double kNear = 64;
    if (!is_near_linear_ || std::abs(x) > kNear || std::abs(y) > kNear) return photo_from_pixel(camera_, q);
    return PhotoPoint{in_photo_.x + along_x_[0] * x + along_y_[0] * y, in_photo_.y + along_x_[1] * x + along_y_[1] * y};
  }

  bool has_like_scale() const {
    const auto edge2 = [&](std::size_t i, std::size_t j) {
      const auto a = at(i), b = at(j);
      if (!a || !b) return 0.0;
      return (a->x - b->x) * (a->x - b->x) + (a->y - b->y) * (a->y - b->y);
    };
    constexpr std::size_t kLast = kPatchEdge - 1, kBelow = kLast * kPatchEdge;
    constexpr double kEdge2 = double{kLast} * kLast * io::kCoarsePixel * io::kCoarsePixel;
    const auto [least, most] =
        std::minmax({edge2(0, kLast), edge2(kBelow, kBelow + kLast), edge2(0, kBelow), edge2(kLast, kBelow + kLast)});
    return least >= kEdge2 / 4 && most <= kEdge2 * 4;
  }

 private:
  CameraPoint camera_point(std::size_t point) const {
    const auto column = static_cast<double>(point % kPatchEdge), row = static_cast<double>(point / kPatchEdge);
    const double depth = double{depths_[point]};
    return {shift_.x + depth * (first_.x + column * column_.x + row * row_.x),
            shift_.y + depth * (first_.y + column * column_.y + row * row_.y),
            shift_.z + depth * (first_.z + column * column_.z + row * row_.z)};
  }

  void set_lens() {
    constexpr std::size_t kMiddle = kPatchEdge / 2 * kPatchEdge + kPatchEdge / 2;
    const CameraPoint p = camera_point(kMiddle);
    if (!(p.z > 0) || shows_pole(camera_.distortion.model)) return;
    middle_ = pixel_from_camera(camera_, p);
    constexpr double kStep = 16;  // px
    const auto lens = [&](double x, double y) { return photo_from_pixel(camera_, {middle_.x + x, middle_.y + y}); };
    const auto here = lens(0, 0), left = lens(-kStep, 0), right = lens(kStep, 0), above = lens(0, -kStep),
               below = lens(0, kStep);
    if (!here || !left || !right || !above || !below) return;
    in_photo_ = *here;
    along_x_ = {(right->x - left->x) / (2 * kStep), (right->y - left->y) / (2 * kStep)};
    along_y_ = {(below->x - above->x) / (2 * kStep), (below->y - above->y) / (2 * kStep)};
    is_near_linear_ = true;
  }

  const Camera& camera_;
  const GridDepths& depths_;
  CameraPoint shift_, first_, column_, row_;
  bool is_near_linear_ = false;
  PixelPoint middle_;
  PhotoPoint in_photo_;
  std::array<double, 2> along_x_{}, along_y_{};
};

/// Bilinear.
std::uint8_t level_at(const CoarseLuma& luma, const PhotoPoint& q) {
  const double u = std::clamp(q.x / io::kCoarsePixel - 0.5, 0.0, luma.width - 1.0);
  const double v = std::clamp(q.y / io::kCoarsePixel - 0.5, 0.0, luma.height - 1.0);
  const int x = static_cast<int>(u), y = static_cast<int>(v);
  const std::uint8_t* upper = luma.levels.data() + pixel_index(x, y, luma.width);
  const std::uint8_t* lower = y + 1 < luma.height ? upper + luma.width : upper;
  const std::size_t right = x + 1 < luma.width ? 1 : 0;
  const auto fx = static_cast<float>(u - x), fy = static_cast<float>(v - y);
  const auto between = [fx, right](const std::uint8_t* at) {
    const auto a = static_cast<float>(at[0]), b = static_cast<float>(at[right]);
    return a + fx * (b - a);
  };
  const float top = between(upper), bottom = between(lower);
  return static_cast<std::uint8_t>(top + fy * (bottom - top) + 0.5f);
}

}  // namespace

GPVC_WIDE_CLONES CoarseLuma coarse_luma(const Image& means) {
  const std::size_t pixels = means.pixels.size() / 3;
  CoarseLuma luma{means.width, means.height, std::vector<std::uint8_t>(pixels)};
  const std::uint8_t* rgb = means.pixels.data();
  std::uint8_t* levels = luma.levels.data();
  for (std::size_t i = 0; i < pixels; ++i)
    levels[i] = static_cast<std::uint8_t>((rgb[3 * i] + 2 * rgb[3 * i + 1] + rgb[3 * i + 2] + 2) / 4);
  return luma;
}

std::optional<Patch> take_patch(const Scene& scene, const SurfacePlace& place, const GridDepths& depths, ViewId id,
                                const CoarseLuma& luma) {
  const View& view = scene.views[index(id)];
  const GridPositions positions(scene.views[index(place.reference)], view, place, depths);
  if (!positions.has_like_scale()) return std::nullopt;
  Patch patch;
  for (std::size_t i = 0; i < patch.luma.size(); ++i) {
    const auto q = positions.at(i);
    if (!q || !(q->x >= 0 && q->y >= 0 && q->x <= view.camera.width && q->y <= view.camera.height)) return std::nullopt;
    patch.luma[i] = level_at(luma, *q);
  }
  return patch;
}

double misfit(double x, double y, const std::array<double, 3>& information) {
  constexpr double kKnownError = 0.25;  // px
  const auto [xx, xy, yy] = information;
  const double most = largest_eigenvalue(xx, xy, yy), least = xx + yy - most;
  const auto share = [](double known) { return std::clamp(known * kKnownError * kKnownError, 0.0, 1.0); };
  // The part along the direction of the largest eigenvalue, and the rest.
  const double angle = std::atan2(2 * xy, xx - yy) / 2;
  const double along = x * std::cos(angle) + y * std::sin(angle), across = y * std::cos(angle) - x * std::sin(angle);
  return std::sqrt(share(most) * along * along + share(least) * across * across);
}

bool has_texture(const Patch& reference) {
  const Template middle(reference);
  const double noise2 = double{kPhotoNoise} * double{kPhotoNoise};
  return largest_eigenvalue(middle.xx, middle.xy, middle.yy) > noise2 * kSamples;
}

std::optional<PatchShift> shift_between(const Patch& reference, const Patch& other) {
  const Template middle(reference);
  if (middle.norm == 0) return std::nullopt;
  const auto whole = best_whole_shift(middle, other);
  if (!whole) return std::nullopt;
  // Along an edge the shift stays where it is: what is unknown takes no step.
  const double damped = 1e-3 * largest_eigenvalue(middle.xx, middle.xy, middle.yy);
  const double xx = middle.xx + damped, yy = middle.yy + damped, determinant = xx * yy - middle.xy * middle.xy;
  if (!(determinant > 0)) return std::nullopt;
  double column = static_cast<double>(whole->column), row = static_cast<double>(whole->row), correlation = 0;
  constexpr int kSteps = 4;
  for (int step = 0;; ++step) {
    Window window = window_between(other, column, row);
    const float norm = center(window);
    if (norm == 0) return std::nullopt;
    correlation = double{product(window, middle.middle)} / (double{norm} * double{middle.norm});
    if (step == kSteps) break;
    // To the gain that makes both alike; gradients are orthogonal to what an offset or a gain change.
    const double gain = double{middle.norm} / (double{norm} * std::max(correlation, 0.1));
    const double x = gain * double{product(window, middle.along_x)}, y = gain * double{product(window, middle.along_y)};
    column -= (yy * x - middle.xy * y) / determinant;
    row -= (xx * y - middle.xy * x) / determinant;
    if (std::abs(column - static_cast<double>(whole->column)) > 1 ||
        std::abs(row - static_cast<double>(whole->row)) > 1)
      return std::nullopt;
  }
  if (!(correlation >= kLeastCorrelation)) return std::nullopt;
  constexpr double kPixel = io::kCoarsePixel;
  PatchShift shift{(column - double{kPatchReach}) * kPixel, (row - double{kPatchReach}) * kPixel, {}, correlation};
  // What is left differs alike in samples next to each other, so a quarter of them tells something new.
  constexpr double kIndependent = 0.25;
  const double left2 = 2 * (1 - std::min(correlation, 0.999)) * double{middle.norm} * double{middle.norm} / kSamples;
  const double factor = kIndependent / (left2 * kPixel * kPixel);
  shift.information = {factor * middle.xx, factor * middle.xy, factor * middle.yy};
  return shift;
}

}  // namespace gpvc::atlas
