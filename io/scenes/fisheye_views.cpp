#include "io/scenes/fisheye_views.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>

#include "io/lens/lens.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// No lens that is made shows more than 250 degrees.
constexpr double kFarthest = 125 * kDegree;

std::optional<double> angle_at(const Camera& camera, const PhotoPoint& p, double most) {
  const auto ray = ray_of_photo(camera, p, most);
  return ray ? std::optional(std::atan2(std::hypot(ray->x, ray->y), ray->z)) : std::nullopt;
}

/// How far from its axis the lens shows something. No file says how large the
/// image circle of a fisheye is. Where it fills the photo, the corners are some 90 degrees from the axis at most; where they
/// are farther, or the lens folds back before them, they are dark, and the circle touches two of the edges.
double image_circle(const Camera& camera) {
  constexpr double kWidestCorner = 92 * kDegree;
  const double most = std::min(largest_angle(camera.distortion), kFarthest);
  const double w = camera.width, h = camera.height;
  const auto farthest = [&](std::initializer_list<PhotoPoint> places, bool all) {
    double angle = 0;
    for (const PhotoPoint& p : places) {
      const std::optional<double> there = angle_at(camera, p, most);
      if (all && !(there && *there <= kWidestCorner)) return 0.0;
      angle = std::max(angle, there.value_or(most));
    }
    return angle;
  };
  const double corners = farthest({{0, 0}, {w, 0}, {0, h}, {w, h}}, true);
  return corners > 0 ? corners : farthest({{0, camera.cy}, {w, camera.cy}, {camera.cx, 0}, {camera.cx, h}}, false);
}

/// The share of what the lens shows that lies outside the frame.
double share_beyond_frame(const Camera& camera, double most) {
  constexpr int kSteps = 32;
  int shown = 0, beyond = 0;
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < kSteps; ++i) {
      const auto ray =
          ray_of_photo(camera, {(i + 0.5) / kSteps * camera.width, (j + 0.5) / kSteps * camera.height}, most);
      if (!ray) continue;
      ++shown;
      if (ray->z > 0) {
        const PixelPoint p = pixel_from_camera(camera, {ray->x, ray->y, ray->z});
        if (p.x >= 0 && p.x <= camera.width && p.y >= 0 && p.y <= camera.height) continue;
      }
      ++beyond;
    }
  return shown > 0 ? static_cast<double>(beyond) / shown : 0;
}

/// v in the axes of a view that looks aside.
std::array<double, 3> turned(const Matrix3& view_from_lens, const std::array<double, 3>& v) {
  const WorldPoint p = product(view_from_lens, WorldPoint{v[0], v[1], v[2]});
  return {p.x, p.y, p.z};
}

}  // namespace

std::vector<View> fisheye_views(const View& view) {
  const Camera& camera = view.camera;
  if (camera.width == 0 || !is_of_angle(camera.distortion.model)) return {view};
  const double most = image_circle(camera);
  constexpr double kTooMuch = 1.0 / 3;
  if (!(share_beyond_frame(camera, most) > kTooMuch)) return {view};

  const double right = std::atan((camera.width - camera.cx) / camera.fx), left = std::atan(camera.cx / camera.fx),
               down = std::atan((camera.height - camera.cy) / camera.fy), up = std::atan(camera.cy / camera.fy);
  const auto across = [](double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return Matrix3{c, 0, s, 0, 1, 0, -s, 0, c};
  };
  const auto upright = [](double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return Matrix3{1, 0, 0, 0, c, s, 0, -s, c};
  };
  const std::filesystem::path name = view.name;
  std::vector<View> views{view};
  for (const auto& [way, lens_from_frame] : {std::pair{"right", across(right)}, std::pair{"left", across(-left)},
                                             std::pair{"down", upright(down)}, std::pair{"up", upright(-up)}}) {
    View& aside = views.emplace_back(view);
    aside.name = (name.parent_path() / name.stem() / way).string() + name.extension().string();
    const Matrix3 frame_from_lens = transposed(lens_from_frame);
    aside.pose.rotation = product(frame_from_lens, view.pose.rotation);
    Distortion& lens = aside.camera.distortion;
    lens.lens_from_frame = lens_from_frame;
    lens.max_angle = most;
    lens.max_r2 = Distortion{}.max_r2;
    lens.motion.turn = turned(frame_from_lens, lens.motion.turn);
    lens.motion.step = turned(frame_from_lens, lens.motion.step);
  }
  return views;
}

}  // namespace gpvc::io
