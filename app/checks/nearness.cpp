#include "app/checks/nearness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "app/checks/coarse_depths.h"
#include "io/vector.h"

namespace gpvc::checks {
namespace {

/// Least squares by the normal equations: three unknowns, with columns of about the same size.
class PlaneFit {
 public:
  void add(const WorldPoint& ray, double inverse_depth) {
    rows_[0] = rows_[0] + ray.x * ray;
    rows_[1] = rows_[1] + ray.y * ray;
    rows_[2] = rows_[2] + ray.z * ray;
    right_ = right_ + inverse_depth * ray;
  }

  /// A plane at the mean inverse depth where the rays lie in too few directions for another one.
  std::array<double, 3> plane() const {
    const WorldPoint a = cross(rows_[1], rows_[2]), b = cross(rows_[2], rows_[0]), c = cross(rows_[0], rows_[1]);
    const double determinant = dot(rows_[0], a), rays = rows_[2].z;
    if (!(rays > 0)) return {};
    // Of a symmetric matrix of squares the determinant is at most the product of the diagonal's entries; below this share
    // of it the quotients have no digits left.
    constexpr double kDegenerate = 1e-10;
    if (!(determinant > kDegenerate * rows_[0].x * rows_[1].y * rays)) return {0, 0, right_.z / rays};
    const WorldPoint sum = right_.x * a + right_.y * b + right_.z * c;
    return {sum.x / determinant, sum.y / determinant, sum.z / determinant};
  }

 private:
  std::array<WorldPoint, 3> rows_{};
  WorldPoint right_{};
};

std::array<double, 3> inverse_depth_plane(const CoarseDepths& coarse, const Camera& camera) {
  PlaneFit fit;
  for (std::size_t row = 0; row < CoarseDepths::kRows; ++row)
    for (std::size_t column = 0; column < CoarseDepths::kColumns; ++column)
      if (const double depth = coarse.depths[row * CoarseDepths::kColumns + column]; std::isfinite(depth))
        fit.add(CoarseDepths::ray(camera, column, row), 1 / depth);
  return fit.plane();
}

}  // namespace

void set_nearness(Scene& scene, const Mesh& mesh, const WorldPoint& offset) {
  std::vector<View*> moving;
  for (View& view : scene.views)
    if (const Motion& m = view.camera.distortion.motion; m.moves() && m.step != Motion{}.step && view.camera.width > 0)
      moving.push_back(&view);
  if (moving.empty()) return;
  const FaceRuns runs(mesh);
  tbb::parallel_for(std::size_t{0}, moving.size(), [&](std::size_t i) {
    View& view = *moving[i];
    View from = view;
    from.pose.centre = from.pose.centre - offset;
    const std::array<double, 3> plane = inverse_depth_plane(draw_coarse_depths(mesh, runs, from), view.camera);
    if (std::ranges::all_of(plane, [](double value) { return std::isfinite(value); }))
      view.camera.distortion.motion.nearness = plane;
  });
}

}  // namespace gpvc::checks
