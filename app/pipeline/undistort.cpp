#include "app/pipeline/undistort.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "io/bilinear.h"

namespace gpvc::pipeline {
namespace {

/// Where two opposite edges of the photo lie in the frame, along the axis across them. Distortion bends the edges: `out` is
/// their outermost place, `in` the innermost.
struct Reach {
  double low_out, low_in, high_out, high_in;
};

/// From the corners of all pixels along both edges: `place(at, i)` is where pixel corner i of the edge at `at`, 0 or `size`,
/// lies in the frame; nullopt if the lens model shows it in no direction ahead of the camera. Such a corner does not bound
/// the inner rectangle and leaves the outer one unbounded.
template <class Place>
Reach reach_of(double size, int corners, const Place& place) {
  Reach reach{size, -size, 0, 2 * size};
  for (int i = 0; i <= corners; ++i) {
    const std::optional<double> low = place(0.0, i), high = place(size, i);
    reach.low_out = std::min(reach.low_out, low.value_or(-size));
    reach.high_out = std::max(reach.high_out, high.value_or(2 * size));
    if (low) reach.low_in = std::max(reach.low_in, *low);
    if (high) reach.high_in = std::min(reach.high_in, *high);
  }
  return reach;
}

/// The whole pixels of a reach, from the first one to behind the last, clamped to half of `size` beyond [0, size] and to
/// `fold` pixels from the centre, where the lens model folds.
std::pair<int, int> whole_pixels(const Reach& reach, int size, double centre, double fold, bool all) {
  const double low = std::max({all ? reach.low_out : reach.low_in, -0.5 * size, centre - fold});
  const double high = std::min({all ? reach.high_out : reach.high_in, 1.5 * size, centre + fold});
  const double first = all ? std::floor(low) : std::ceil(low);
  const double last = all ? std::ceil(high) : std::floor(high);
  return {static_cast<int>(first), std::max(static_cast<int>(last), static_cast<int>(first))};
}

/// How many square pixels of `step` pixels of the camera, half to each side of `centre`, a reach has room for; clamped
/// like whole_pixels.
int centred_pixels(const Reach& reach, int size, double centre, double fold, double step, bool all) {
  const double low = centre - (all ? reach.low_out : reach.low_in),
               high = (all ? reach.high_out : reach.high_in) - centre;
  const double half = std::min(all ? std::max(low, high) : std::min(low, high), fold) / step;
  const double pixels = std::clamp(2 * half, 0.0, 2.0 * size);
  return static_cast<int>(all ? std::ceil(pixels) : std::floor(pixels));
}

/// Borders of a window with a blank pixel. Where there is none, nothing inside the window is blank, because the photo's
/// edge is one closed curve in the frame.
struct Blanks {
  bool left = false, right = false, top = false, bottom = false;
  bool any() const { return left || right || top || bottom; }
};

Blanks blanks_of(const Camera& camera, const FrameWindow& w) {
  const auto blank = [&](int x, int y) { return !in_photo(camera, frame_position(camera, w, x, y)); };
  Blanks blanks;
  for (int y = 0; y < w.height; ++y) {
    blanks.left = blanks.left || blank(0, y);
    blanks.right = blanks.right || blank(w.width - 1, y);
  }
  for (int x = 0; x < w.width; ++x) {
    blanks.top = blanks.top || blank(x, 0);
    blanks.bottom = blanks.bottom || blank(x, w.height - 1);
  }
  return blanks;
}

/// Calls `use(x, y, place in the photo)` for every pixel of the window that shows something of the photo; TBB.
template <class Use>
void for_each_shown_pixel(const Camera& camera, const FrameWindow& window, const Use& use) {
  tbb::parallel_for(0, window.height, [&](int y) {
    for (int x = 0; x < window.width; ++x) {
      const PixelPoint centre = frame_position(camera, window, x, y);
      if (in_photo(camera, centre)) use(x, y, *photo_from_pixel(camera, centre));
    }
  });
}

/// The window less its blank borders, unless `all`; the photo's own size where too little is left.
FrameWindow trimmed_window(const Camera& camera, FrameWindow window, bool all) {
  while (!all && window.width > 0 && window.height > 0) {
    const Blanks blanks = blanks_of(camera, window);
    if (!blanks.any()) break;
    if (window.centred) {
      window.width -= 2 * (blanks.left || blanks.right);
      window.height -= 2 * (blanks.top || blanks.bottom);
      continue;
    }
    window.x += blanks.left;
    window.y += blanks.top;
    window.width -= blanks.left + blanks.right;
    window.height -= blanks.top + blanks.bottom;
  }
  constexpr int kLeast = 5;
  const bool enough = kLeast * window.width >= camera.width && kLeast * window.height >= camera.height;
  return enough ? window : FrameWindow{0, 0, camera.width, camera.height, window.centred};
}

}  // namespace

PixelPoint frame_position(const Camera& camera, const FrameWindow& w, int x, int y) {
  if (!w.centred) return {w.x + x + 0.5, w.y + y + 0.5};
  const double f = std::max(camera.fx, camera.fy);
  return {camera.cx + (x + 0.5 - w.width / 2.0) * (camera.fx / f),
          camera.cy + (y + 0.5 - w.height / 2.0) * (camera.fy / f)};
}

bool shows_blank(const Camera& camera, const FrameWindow& window) { return blanks_of(camera, window).any(); }

FrameWindow frame_window(const Camera& camera, FrameRule rule, bool centred) {
  const FrameWindow own{0, 0, camera.width, camera.height, centred};
  Camera pinhole = camera;
  pinhole.distortion = {};
  const bool spherical = is_spherical(camera.distortion.model);
  if (spherical && rule == FrameRule::keep) rule = FrameRule::inside;
  if (rule == FrameRule::keep || (camera.distortion.is_identity() && camera_of_window(camera, own) == pinhole))
    return own;
  const bool all = rule == FrameRule::all;
  const auto place = [&camera](double x, double y, double PixelPoint::*axis) -> std::optional<double> {
    const std::optional<PixelPoint> p = pixel_from_photo(camera, {x, y});
    return p ? std::optional((*p).*axis) : std::nullopt;
  };
  // Edges of a panorama do not bound its views.
  const auto unbounded = [](double size) { return Reach{-size, -size, 2 * size, 2 * size}; };
  const Reach across = spherical ? unbounded(camera.width)
                                 : reach_of(camera.width, camera.height,
                                            [&](double x, double y) { return place(x, y, &PixelPoint::x); });
  const Reach down = spherical ? unbounded(camera.height)
                               : reach_of(camera.height, camera.width,
                                          [&](double y, double x) { return place(x, y, &PixelPoint::y); });
  const double fold = std::sqrt(camera.distortion.max_r2);
  if (centred) {
    const double f = std::max(camera.fx, camera.fy);
    FrameWindow window = own;
    window.width = centred_pixels(across, camera.width, camera.cx, fold * camera.fx, camera.fx / f, all);
    window.height = centred_pixels(down, camera.height, camera.cy, fold * camera.fy, camera.fy / f, all);
    return trimmed_window(camera, window, all);
  }
  const auto [x0, x1] = whole_pixels(across, camera.width, camera.cx, fold * camera.fx, all);
  const auto [y0, y1] = whole_pixels(down, camera.height, camera.cy, fold * camera.fy, all);
  return trimmed_window(camera, {x0, y0, x1 - x0, y1 - y0}, all);
}

Camera camera_of_window(const Camera& camera, const FrameWindow& window) {
  if (window.centred) {
    const double f = std::max(camera.fx, camera.fy);
    return {window.width, window.height, f, f, window.width / 2.0, window.height / 2.0, {}};
  }
  return {window.width, window.height, camera.fx, camera.fy, camera.cx - window.x, camera.cy - window.y, {}};
}

Image undistort_photo(const Image& photo, const Camera& camera, const FrameWindow& window,
                      std::vector<std::uint8_t>& inside) {
  const std::size_t pixels = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
  Image frame{window.width, window.height, 3, std::vector<std::uint8_t>(3 * pixels)};
  inside.assign(pixels, 0);
  for_each_shown_pixel(camera, window, [&](int x, int y, const PhotoPoint& p) {
    const Rgb color = bilinear(photo, p.x, p.y);
    for (std::size_t c = 0; c < 3; ++c) frame.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(color[c]));
    inside[static_cast<std::size_t>(frame.at(x, y) - frame.at(0, 0)) / 3] = 255;
  });
  return frame;
}

Image undistort_mask(const io::PhotoExclusion* exclusion, const Camera& camera, const FrameWindow& window) {
  const std::size_t pixels = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
  Image mask{window.width, window.height, 1, std::vector<std::uint8_t>(pixels)};
  for_each_shown_pixel(camera, window, [&](int x, int y, const PhotoPoint& p) {
    const double u = std::clamp(p.x - 0.5, 0.0, camera.width - 1.0),
                 v = std::clamp(p.y - 0.5, 0.0, camera.height - 1.0);
    const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
    const int x1 = u > x0 ? x0 + 1 : x0, y1 = v > y0 ? y0 + 1 : y0;
    const bool excluded = exclusion != nullptr && (exclusion->excludes(x0, y0) || exclusion->excludes(x1, y0) ||
                                                   exclusion->excludes(x0, y1) || exclusion->excludes(x1, y1));
    *mask.at(x, y) = excluded ? 0 : 255;
  });
  return mask;
}

Image mask_image(const io::PhotoExclusion& exclusion) {
  Image mask{exclusion.width, exclusion.height, 1, {}};
  mask.pixels.reserve(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height));
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) mask.pixels.push_back(exclusion.excludes(x, y) ? 0 : 255);
  return mask;
}

}  // namespace gpvc::pipeline
