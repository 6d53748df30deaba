#include "visibility/native/face_hulls.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/box.h"
#include "io/vector.h"
#include "visibility/classify/face_scan.h"

namespace gpvc::visibility {
namespace {

/// A linear function x X + y Y + z Z of a place in the camera's axes, below 0
/// beyond one side of what the frame shows.
struct Side {
  WorldPoint gradient;
  double weight;  ///< no component of the gradient is the sum of larger terms

  Side(const Pose& pose, double x, double y, double z)
      : gradient(to_world_axes(pose, {x, y, z})), weight(std::abs(x) + std::abs(y) + std::abs(z)) {}
  /// The most that it differs from that at the box's middle.
  double spread(const WorldPoint& half) const {
    return std::abs(gradient.x) * half.x + std::abs(gradient.y) * half.y + std::abs(gradient.z) * half.z;
  }
};

double size(const WorldPoint& p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z); }

}  // namespace

FaceHulls::FaceHulls(const Mesh& mesh) {
  const std::size_t faces = mesh.faces.size();
  boxes_.resize((faces + kFacesPerRectangle - 1) / kFacesPerRectangle);
  tbb::parallel_for(std::size_t{0}, boxes_.size(), [&](std::size_t n) {
    const auto [low, high] = box_of_faces(mesh, n * kFacesPerRectangle, std::min((n + 1) * kFacesPerRectangle, faces));
    boxes_[n] = {0.5 * (low + high), 0.5 * (high - low)};
  });
}

void FaceHulls::find_beside(const Camera& camera, const Pose& pose, std::vector<std::uint8_t>& beside) const {
  // What is rounded, here and where a vertex is projected, adds up to less than
  // 2^-48 of the terms' sizes. 16 times that is still far below a pixel.
  constexpr double kSlack = 0x1p-44;
  const double w = camera.width, h = camera.height;
  const std::array sides{Side(pose, 0, 0, 1), Side(pose, camera.fx, 0, camera.cx),
                         Side(pose, -camera.fx, 0, w - camera.cx), Side(pose, 0, camera.fy, camera.cy),
                         Side(pose, 0, -camera.fy, h - camera.cy)};
  beside.resize(boxes_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, boxes_.size(), 1024), [&](const auto& range) {
    for (std::size_t n = range.begin(); n != range.end(); ++n) {
      const Box& box = boxes_[n];
      const WorldPoint middle = box.middle - pose.centre;
      const double slack = kSlack * (size(box.middle) + size(box.half) + size(pose.centre));
      beside[n] = std::ranges::any_of(sides, [&](const Side& side) {
        return dot(side.gradient, middle) + side.spread(box.half) < -side.weight * slack;
      });
    }
  });
}

}  // namespace gpvc::visibility
