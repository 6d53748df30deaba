#include "app/checks/sighting_shift.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "io/order_statistics.h"

namespace gpvc::checks {
namespace {

/// Where a photo shows a point, beside where its camera does.
struct Residual {
  double x, y;         ///< of where the camera shows it, from the principal point
  double right, down;  ///< from there to where the photo does
};

/// What the views of a camera show.
struct Residuals {
  ViewId first{};
  std::size_t views = 0;
  std::vector<Residual> all;
};

constexpr double kLeastGrowth = 0.01;
constexpr std::size_t kLeast = 50;

/// Appends by how much `moved` grows with `place` between residuals half of all apart (Theil's incomplete method, 1950):
/// whatever side of the photo most of them lie on, a shift common to all adds nothing.
void add_slopes(std::vector<Residual>& residuals, double Residual::*place, double Residual::*moved, double least_apart,
                std::vector<double>& slopes) {
  std::ranges::sort(residuals, {}, place);
  const std::size_t half = residuals.size() / 2;
  for (std::size_t i = 0; i + half < residuals.size(); ++i) {
    const Residual &a = residuals[i], &b = residuals[i + half];
    if (const double apart = b.*place - a.*place; apart > least_apart) slopes.push_back((b.*moved - a.*moved) / apart);
  }
}

std::optional<SightingShift> shift_of(Residuals& of, const View& view) {
  std::vector<double> slopes;
  add_slopes(of.all, &Residual::x, &Residual::right, view.camera.width / 8.0, slopes);
  add_slopes(of.all, &Residual::y, &Residual::down, view.camera.height / 8.0, slopes);
  // Points that lie close together do not tell a shift from growth.
  if (of.all.size() < kLeast || slopes.size() < kLeast / 2) return {};
  const double growth = upper_median(std::span(slopes));
  std::vector<double> right, down;
  for (const Residual& each : of.all) {
    right.push_back(each.right - growth * each.x);
    down.push_back(each.down - growth * each.y);
  }
  SightingShift found{of.first, of.views, upper_median(std::span(right)), upper_median(std::span(down))};
  const double shift = std::hypot(found.right, found.down);
  if (std::abs(growth) <= kLeastGrowth) return shift * view.reduction >= 1 ? std::optional(found) : std::nullopt;
  // Cameras of photos of another size than the model states were scaled about the photo's corner, the points were not, which
  // moves those in the middle as well. Where the views of a camera differ among themselves, it is no mistake of the camera's.
  constexpr double kSteady = 0.25;
  for (double& each : slopes) each = std::abs(each - growth);
  const double middle = std::min(view.camera.cx, view.camera.cy);
  if (shift > kSteady * std::abs(growth) * middle || upper_median(std::span(slopes)) > kSteady * std::abs(growth))
    return {};
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
    const std::optional<PhotoPoint> shown = photo_from_world(view, sighting.point);
    if (!shown) continue;
    Residuals& of = cameras[{camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy}];
    if (of.views == 0) of.first = sighting.view;
    if (last != sighting.view) ++of.views;
    last = sighting.view;
    of.all.push_back({shown->x - camera.cx, shown->y - camera.cy, sighting.at.x - shown->x, sighting.at.y - shown->y});
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
