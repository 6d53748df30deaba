#include "io/lens/spherical.h"

namespace gpvc::io {

PlanePoint sphere_from_plane(LensModel model, double x, double y) {
  if (model == LensModel::spherical_up) return {std::atan2(x, y), std::atan2(-1, std::hypot(x, y))};
  if (model == LensModel::spherical_down) return {std::atan2(x, -y), std::atan2(1, std::hypot(x, y))};
  return {std::atan(x), std::atan2(y, std::hypot(x, 1))};
}

std::optional<PlanePoint> plane_from_sphere(LensModel model, double longitude, double latitude) {
  const bool pole = shows_pole(model);
  const double most = pole ? std::numbers::pi : std::numbers::pi / 2;
  if (!(std::abs(longitude) <= most && std::abs(latitude) <= std::numbers::pi / 2)) return std::nullopt;
  // The direction, right, down and forward.
  const double across = std::cos(latitude);
  const double x = across * std::sin(longitude), y = std::sin(latitude), z = across * std::cos(longitude);
  const double ahead = !pole ? z : model == LensModel::spherical_up ? -y : y;
  if (!(ahead > 0)) return std::nullopt;
  if (!pole) return PlanePoint{x / ahead, y / ahead};
  return PlanePoint{x / ahead, (model == LensModel::spherical_up ? z : -z) / ahead};
}

}  // namespace gpvc::io
