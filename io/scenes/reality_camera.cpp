#include "io/scenes/reality_camera.h"

#include <algorithm>

namespace gpvc::io {

Camera camera_from(const RealityCamera& reality) {
  constexpr double kFilmWidth_mm = 36;
  const double focal = reality.focal_35mm / kFilmWidth_mm;
  Camera camera{0, 0, focal, focal, reality.px, reality.py, {}};
  set_brown_terms(reality.coefficients, camera);
  return camera;
}

void size_reality_camera(Camera& camera, int width, int height) {
  const double longer = std::max(width, height);
  camera.fx *= longer;
  camera.fy *= longer;
  camera.cx = camera.cx * longer + width / 2.0;
  camera.cy = camera.cy * longer + height / 2.0;
}

void set_brown_terms(const std::array<double, 6>& coefficients, Camera& camera) {
  Distortion& d = camera.distortion;
  d.model = LensModel::perspective;
  d.k1 = coefficients[0];
  d.k2 = coefficients[1];
  d.k3 = coefficients[2];
  d.k4 = coefficients[3];
  d.p2 = coefficients[4];
  d.p1 = coefficients[5];
}

}  // namespace gpvc::io
