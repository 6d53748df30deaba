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

constexpr double kLeastGrowth = 0.01;
constexpr std::size_t kLeast = 50;

std::optional<SightingShift> shift_of(Residuals& of, const View& view) {
  if (of.right.size() < kLeast || of.growth.size() < kLeast) return {};
  SightingShift found{of.first, of.views, median(of.right), median(of.down)};
  const double growth = median(of.growth), shift = std::hypot(found.right, found.down);
  if (std::abs(growth) <= kLeastGrowth) return shift * view.reduction >= 1 ? std::optional(found) : std::nullopt;
  // Cameras of photos of another size than the model states were scaled about the photo's corner, the points were not, which
  // moves those in the middle as well. Where the views of a camera differ among themselves, it is no mistake of the camera's.
  constexpr double kSteady = 0.25;
  for (double& each : of.growth) each = std::abs(each - growth);
  const double middle = std::min(view.camera.cx, view.camera.cy);
  if (shift > kSteady * std::abs(growth) * middle || median(of.growth) > kSteady * std::abs(growth)) return {};
  found.right = found.down = 0;
  found.growth = growth;
  return found;
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
    if (const auto shift = shift_of(residuals, scene.views[index(residuals.first)])) shifts.push_back(*shift);
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
  const std::string who =
      one ? view.name + " shows its" : fmt::format("{} and {} more show their", view.name, shift.views - 1);
  const char* camera = one ? "its camera" : "their camera";
  if (shift.growth == 0)
    return fmt::format(
        "{} tie points {} where {} does: the principal point is off by as much, or the photos were cropped", who,
        fmt::join(parts, " and "), camera);
  const double longer = 1 / (1 + shift.growth) - 1;
  return fmt::format(
      "{} tie points {:.1f} % {} the principal point than {} does: the focal length is {:.0f} % too {}, or the photos "
      "were reduced and cropped",
      who, 100 * std::abs(shift.growth), shift.growth < 0 ? "nearer to" : "farther from", camera,
      100 * std::abs(longer), longer > 0 ? "long" : "short");
}

}  // namespace gpvc::checks
