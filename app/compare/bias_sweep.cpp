#include "app/compare/bias_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "io/order_statistics.h"
#include "visibility/method.h"

namespace gpvc::compare {
namespace {

constexpr std::size_t kMostViews = 16, kMostVertices = 100000;

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
};

/// Adds the depths of the vertices in the frame; returns the depths of all.
Range add_depths(const Mesh& mesh, const View& view, std::vector<double>& depths) {
  Range range;
  const std::size_t step = 1 + mesh.positions.size() / kMostVertices;
  for (std::size_t v = 0; v < mesh.positions.size(); v += step) {
    const CameraPoint p = camera_from_world(view.pose, mesh.positions[v]);
    range = {std::min(range.low, p.z), std::max(range.high, p.z)};
    if (!(p.z > 0)) continue;
    const PixelPoint at = pixel_from_camera(view.camera, p);
    if (at.x >= 0 && at.y >= 0 && at.x <= view.camera.width && at.y <= view.camera.height) depths.push_back(p.z);
  }
  return range;
}

}  // namespace

BiasScale::BiasScale(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used) {
  std::vector<double> depths, factors;
  const std::size_t count = std::min(used.size(), kMostViews);
  for (std::size_t n = 0; n < count; ++n) {
    const Range range = add_depths(mesh, scene.views[index(used[n * used.size() / count])], depths);
    // The planes that shadow_map draws with: F N / (F - N) is what formula 3 divides by z.
    const double far = range.high, near = std::max(range.low, far * 0x1p-14);
    if (far > near) factors.push_back(far * near / (far - near));
  }
  if (!depths.empty()) depth_ = upper_median(std::span(depths));
  if (!factors.empty()) spc_factor_ = upper_median(std::span(factors));
}

double BiasScale::per_share(const std::string& family) const {
  // The derivative of factor / z by z, times z.
  if (family == "shadow-map:apc") return visibility::kShadowMapNear / depth_;
  if (family == "shadow-map:spc") return spc_factor_ / depth_;
  return depth_;
}

std::vector<double> BiasScale::sweep(const std::string& family) const {
  // Two numbers that should be equal differ by up to 2^-23 of themselves once rounded to floats. Window depths under SPC
  // are mostly next to 1; the other two compare numbers of the size of per_share(). On interpolated depths, twice that
  // still lets surfaces hide themselves.
  const double rounding = 0x1p-23 * (family == "shadow-map:spc" ? 1 : per_share(family));
  const int first = static_cast<int>(std::floor(std::log10(2 * rounding)));
  const int last = std::max(first + 2, static_cast<int>(std::lround(std::log10(0.01 * per_share(family)))));
  std::vector<double> epsilons;
  for (int exponent = first; exponent <= last; ++exponent)
    epsilons.push_back(std::stod(fmt::format("1e{}", exponent)));  // rounded correctly, unlike pow()
  return epsilons;
}

}  // namespace gpvc::compare
