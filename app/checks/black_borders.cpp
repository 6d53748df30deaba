#include "app/checks/black_borders.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace gpvc::checks {
namespace {

constexpr double kBorder = 0.005;  // of a photo: shadows at its edge reach a few pixels into it

// JPEG makes a little grey of black.
bool is_black(const std::uint8_t* pixel) {
  constexpr int kBlack = 12;
  return std::max({pixel[0], pixel[1], pixel[2]}) <= kBlack;
}

}  // namespace

double black_border_share(const Image& photo) {
  const int width = photo.width, height = photo.height;
  const auto black = [&](int x, int y) { return is_black(photo.at(x, y)); };
  std::vector<int> left(static_cast<std::size_t>(height)), right(left);  // where a row's border ends, and begins again
  std::size_t count = 0;
  for (int y = 0; y < height; ++y) {
    int from = 0, to = width;
    while (from < width && black(from, y)) ++from;
    while (to > from && black(to - 1, y)) --to;
    left[static_cast<std::size_t>(y)] = from;
    right[static_cast<std::size_t>(y)] = to;
    count += static_cast<std::size_t>(width - (to - from));
  }
  const auto counted = [&](int x, int y) {
    return x < left[static_cast<std::size_t>(y)] || x >= right[static_cast<std::size_t>(y)];
  };
  for (int x = 0; x < width; ++x) {
    int y = 0;
    for (; y < height && black(x, y); ++y) count += counted(x, y) ? 0 : 1;
    for (int up = height - 1; up > y && black(x, up); --up) count += counted(x, up) ? 0 : 1;
  }
  return static_cast<double>(count) / (static_cast<double>(width) * height);
}

void BlackBorders::add(const Camera& camera, const Image& photo) {
  if (is_spherical(camera.distortion.model) || camera.distortion.max_angle > 0) return;
  ++photos_;
  const double share = black_border_share(photo);
  if (share <= kBorder) return;
  ++bordered_;
  share_ += share;
}

Remark BlackBorders::remark() const {
  if (bordered_ == 0 || 2 * bordered_ < photos_) return {};
  return {
      fmt::format("{} of {} photos are black along their borders, on {:.1f} % of their pixels: what undistortion or "
                  "cutting out leaves is taken for the surface's colour",
                  bordered_, photos_, 100 * share_ / static_cast<double>(bordered_)),
      {Cure::mask_photos}};
}

}  // namespace gpvc::checks
