#include "app/checks/sighting_shift.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

namespace gpvc::checks {
namespace {

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// What the views of a camera show.
struct Residuals {
  ViewId first{};
  std::size_t views = 0;
  std::vector<double> right, down;
  std::vector<double> growth;  ///< per pixel from the middle
};

// Photos of another size than the model states show points farther out: their cameras were scaled, the points are not.
constexpr double kMostGrowth = 0.01;
constexpr std::size_t kLeast = 50;

std::optional<SightingShift> shift_of(Residuals& of, double reduction) {
  if (of.right.size() < kLeast || of.growth.size() < kLeast || std::abs(median(of.growth)) > kMostGrowth) return {};
  const SightingShift shift{of.first, of.views, median(of.right), median(of.down)};
  return std::hypot(shift.right, shift.down) * reduction >= 1 ? std::optional(shift) : std::nullopt;
}

}  // namespace

std::vector<SightingShift> sighting_shifts(const Scene& scene, std::span<const io::Sighting> sightings) {
  // Files repeat a camera for each of its photos.
  std::map<std::tuple<int, int, double, double, double, double>, Residuals> cameras;
  std::optional<ViewId> last;
  for (const io::Sighting& sighting : sightings) {
    const View& view = scene.views[index(sighting.view)];
    const Camera& camera = view.camera;
    const CameraPoint c = camera_from_world(view.pose, sighting.point);
    if (!(c.z > 0)) continue;
    const std::optional<PhotoPoint> shown = photo_from_pixel(camera, pixel_from_camera(camera, c));
    if (!shown) continue;
    Residuals& of = cameras[{camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy}];
    if (of.views == 0) of.first = sighting.view;
    if (last != sighting.view) ++of.views;
    last = sighting.view;
    const double right = sighting.at.x - shown->x, down = sighting.at.y - shown->y;
    of.right.push_back(right);
    of.down.push_back(down);
    if (const double x = shown->x - camera.cx; std::abs(x) > camera.width / 8.0) of.growth.push_back(right / x);
  }
  std::vector<SightingShift> shifts;
  for (auto& [camera, residuals] : cameras)
    if (const auto shift = shift_of(residuals, scene.views[index(residuals.first)].reduction)) shifts.push_back(*shift);
  std::ranges::sort(shifts, {}, &SightingShift::view);
  return shifts;
}

std::string shift_text(const Scene& scene, const SightingShift& shift) {
  const View& view = scene.views[index(shift.view)];
  std::vector<std::string> parts;
  const auto add = [&](double pixels, const char* positive, const char* negative) {
    constexpr double kTold = 0.5;
    const double size = std::abs(pixels) * view.reduction;
    if (size >= kTold) parts.push_back(fmt::format("{:.1f} pixels {}", size, pixels < 0 ? negative : positive));
  };
  add(shift.right, "right of", "left of");
  add(shift.down, "below", "above");
  const bool one = shift.views == 1;
  return fmt::format(
      "{} tie points {} where {} does: the principal point is off by as much, or the photos were cropped",
      one ? view.name + " shows its" : fmt::format("{} and {} more show their", view.name, shift.views - 1),
      fmt::join(parts, " and "), one ? "its camera" : "their camera");
}

}  // namespace gpvc::checks
