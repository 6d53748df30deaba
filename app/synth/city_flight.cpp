// The cameras that photograph the synthetic city.
#include <cmath>
#include <cstdio>

#include "app/synth/city.h"
#include "io/vector.h"

namespace gpvc::synth {
namespace {

// The pose of a camera that looks along `forward`, with the photo's x axis near `right`.
Pose look(const WorldPoint& centre, const WorldPoint& forward, const WorldPoint& right) {
  const WorldPoint z = unit(forward), x0 = unit(right);
  const WorldPoint y = unit(cross(z, x0)), x = cross(y, z);
  return {{x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}, centre};
}

Camera flight_camera(const FlightOptions& options) {
  Camera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = options.width * (5.0 / 6);
  camera.cx = options.width / 2.0;
  camera.cy = options.height / 2.0;
  if (options.distorted) {
    camera.cx += options.width * 0.006;
    camera.cy -= options.height * 0.005;
    camera.distortion.k1 = -0.06;
    camera.distortion.k2 = 0.015;
    camera.distortion.p1 = 0.0004;
    camera.distortion.p2 = -0.0003;
    limit_distortion(camera);
  }
  return camera;
}

struct Heading {
  const char* name;
  double x, y;  // horizontal viewing direction of an oblique camera
};

}  // namespace

std::vector<View> synth_flight(const FlightOptions& options) {
  constexpr Heading kHeadings[5] = {
      {"east", 1, 0}, {"nadir", 0, 0}, {"north", 0, 1}, {"south", 0, -1}, {"west", -1, 0}};
  const Camera camera = flight_camera(options);
  std::vector<View> views;
  for (int group = 0; group < 5; ++group) {
    // Nadir photos come first in sharing the remainder.
    const int order = (group + 4) % 5;
    const int share = options.photos / 5 + (order < options.photos % 5 ? 1 : 0);
    const int count = !options.all_nadir ? share : order == 0 ? options.photos : 0;
    const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
    const int rows = count == 0 ? 0 : (count + columns - 1) / columns;
    const Heading& heading = kHeadings[group];
    const bool nadir = heading.x == 0 && heading.y == 0;
    for (int n = 0; n < count; ++n) {
      const int row = n / columns, in_row = row + 1 < rows ? columns : count - columns * row;
      const double gx = (n % columns + 0.5) / in_row - 0.5, gy = (row + 0.5) / rows - 0.5;
      const auto wobble = [&](std::uint32_t what) {
        return synth_chance(options.seed * 31 + 7, static_cast<std::uint32_t>(group * 4096 + n), what) - 0.5;
      };
      const WorldPoint target{options.size_m * (gx + 0.06 * wobble(1)), options.size_m * (gy + 0.06 * wobble(2)),
                              options.target_m};
      const double range = options.size_m * (options.range + 0.06 * wobble(3));
      // Oblique cameras look down by about 45 degrees. Nadir photos of every second strip are turned by 180 degrees.
      const WorldPoint forward = nadir ? WorldPoint{0.05 * wobble(4), 0.05 * wobble(5), -1}
                                       : unit({heading.x + 0.1 * wobble(4), heading.y + 0.1 * wobble(5), -1});
      const double turn = row % 2 == 0 ? 1 : -1;
      const WorldPoint right =
          nadir ? WorldPoint{turn, 0.08 * wobble(6), 0} : WorldPoint{heading.y, -heading.x, 0.05 * wobble(6)};
      const WorldPoint centre = target - forward * range;
      View view;
      char name[32];
      std::snprintf(name, sizeof name, "%s_%03d.jpg", heading.name, n + 1);
      view.name = name;
      view.camera = camera;
      view.pose = look(centre, forward, right);
      views.push_back(view);
    }
  }
  return views;
}

}  // namespace gpvc::synth
