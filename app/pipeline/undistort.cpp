#include "app/pipeline/undistort.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "io/bilinear.h"

namespace gpvc::pipeline {
namespace {

/// The outermost and innermost place in the frame of each edge of the photo, which distortion bends.
struct Reach {
  double left_out, left_in, right_out, right_in, top_out, top_in, bottom_out, bottom_in;
};

/// From the corners of all pixels along the four edges. A place that the lens model shows in no direction ahead of the
/// camera does not bound the inner rectangle and leaves the outer one unbounded.
Reach reach_of(const Camera& c) {
  const double w = c.width, h = c.height;
  Reach reach{w, -w, 0, 2 * w, h, -h, 0, 2 * h};
  const auto at = [&c](double x, double y) { return pixel_from_photo(c, {x, y}); };
  for (int y = 0; y <= c.height; ++y) {
    const auto left = at(0, y), right = at(w, y);
    reach.left_out = std::min(reach.left_out, left ? left->x : -w);
    reach.right_out = std::max(reach.right_out, right ? right->x : 2 * w);
    if (left) reach.left_in = std::max(reach.left_in, left->x);
    if (right) reach.right_in = std::min(reach.right_in, right->x);
  }
  for (int x = 0; x <= c.width; ++x) {
    const auto top = at(x, 0), bottom = at(x, h);
    reach.top_out = std::min(reach.top_out, top ? top->y : -h);
    reach.bottom_out = std::max(reach.bottom_out, bottom ? bottom->y : 2 * h);
    if (top) reach.top_in = std::max(reach.top_in, top->y);
    if (bottom) reach.bottom_in = std::min(reach.bottom_in, bottom->y);
  }
  return reach;
}

/// Whole pixels between two places, clamped to half of `size` beyond [0, size] and to `fold` pixels from the centre,
/// where the lens model folds.
std::pair<int, int> whole_pixels(double low, double high, int size, double centre, double fold, bool outwards) {
  low = std::max({low, -0.5 * size, centre - fold});
  high = std::min({high, 1.5 * size, centre + fold});
  const double first = outwards ? std::floor(low) : std::ceil(low);
  const double last = outwards ? std::ceil(high) : std::floor(high);
  return {static_cast<int>(first), std::max(static_cast<int>(last), static_cast<int>(first))};
}

/// Borders of a window with a blank pixel. Where there is none, nothing inside the window is blank, because the photo's
/// edge is one closed curve in the frame.
struct Blanks {
  bool left = false, right = false, top = false, bottom = false;
  bool any() const { return left || right || top || bottom; }
};

Blanks blanks_of(const Camera& camera, const FrameWindow& w) {
  const auto blank = [&](int x, int y) { return !in_photo(camera, {x + 0.5, y + 0.5}); };
  Blanks blanks;
  for (int y = w.y; y < w.y + w.height; ++y) {
    blanks.left = blanks.left || blank(w.x, y);
    blanks.right = blanks.right || blank(w.x + w.width - 1, y);
  }
  for (int x = w.x; x < w.x + w.width; ++x) {
    blanks.top = blanks.top || blank(x, w.y);
    blanks.bottom = blanks.bottom || blank(x, w.y + w.height - 1);
  }
  return blanks;
}

}  // namespace

bool shows_blank(const Camera& camera, const FrameWindow& window) { return blanks_of(camera, window).any(); }

FrameWindow frame_window(const Camera& camera, FrameRule rule) {
  const FrameWindow own{0, 0, camera.width, camera.height};
  if (rule == FrameRule::keep || camera.distortion.is_identity()) return own;
  const bool all = rule == FrameRule::all;
  const Reach reach = reach_of(camera);
  const double fold = std::sqrt(camera.distortion.max_r2);
  const auto [x0, x1] = whole_pixels(all ? reach.left_out : reach.left_in, all ? reach.right_out : reach.right_in,
                                     camera.width, camera.cx, fold * camera.fx, all);
  const auto [y0, y1] = whole_pixels(all ? reach.top_out : reach.top_in, all ? reach.bottom_out : reach.bottom_in,
                                     camera.height, camera.cy, fold * camera.fy, all);
  FrameWindow window{x0, y0, x1 - x0, y1 - y0};
  while (!all && window.width > 0 && window.height > 0) {
    const Blanks blanks = blanks_of(camera, window);
    if (!blanks.any()) break;
    window.x += blanks.left;
    window.y += blanks.top;
    window.width -= blanks.left + blanks.right;
    window.height -= blanks.top + blanks.bottom;
  }
  constexpr int kLeast = 5;
  const bool enough = kLeast * window.width >= camera.width && kLeast * window.height >= camera.height;
  return enough ? window : own;
}

Camera camera_of_window(const Camera& camera, const FrameWindow& window) {
  return {window.width, window.height, camera.fx, camera.fy, camera.cx - window.x, camera.cy - window.y, {}};
}

Image undistort_photo(const Image& photo, const Camera& camera, const FrameWindow& window,
                      std::vector<std::uint8_t>& inside) {
  Image frame;
  frame.width = window.width;
  frame.height = window.height;
  frame.channels = 3;
  const auto width = static_cast<std::size_t>(window.width);
  frame.pixels.assign(width * static_cast<std::size_t>(window.height) * 3, 0);
  inside.assign(width * static_cast<std::size_t>(window.height), 0);
  tbb::parallel_for(tbb::blocked_range<int>(0, window.height), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = 0; x < window.width; ++x) {
        const PixelPoint centre{window.x + x + 0.5, window.y + y + 0.5};
        if (!in_photo(camera, centre)) continue;
        const PhotoPoint p = *photo_from_pixel(camera, centre);
        const Rgb color = bilinear(photo, p.x, p.y);
        for (std::size_t c = 0; c < 3; ++c) frame.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(color[c]));
        inside[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] = 255;
      }
  });
  return frame;
}

Image undistort_mask(const io::PhotoExclusion* exclusion, const Camera& camera, const FrameWindow& window) {
  Image mask{window.width, window.height, 1, {}};
  mask.pixels.assign(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height), 0);
  tbb::parallel_for(0, window.height, [&](int y) {
    for (int x = 0; x < window.width; ++x) {
      const PixelPoint centre{window.x + x + 0.5, window.y + y + 0.5};
      if (!in_photo(camera, centre)) continue;
      bool used = true;
      if (exclusion != nullptr) {
        const PhotoPoint p = *photo_from_pixel(camera, centre);
        const double u = std::clamp(p.x - 0.5, 0.0, camera.width - 1.0),
                     v = std::clamp(p.y - 0.5, 0.0, camera.height - 1.0);
        const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
        const int x1 = u > x0 ? x0 + 1 : x0, y1 = v > y0 ? y0 + 1 : y0;
        used = !(exclusion->excludes(x0, y0) || exclusion->excludes(x1, y0) || exclusion->excludes(x0, y1) ||
                 exclusion->excludes(x1, y1));
      }
      *mask.at(x, y) = used ? 255 : 0;
    }
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
