// A mesh that rays can be traced against. Only this header's source uses Embree.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "visibility/raster/prepared_view.h"

namespace gpvc::visibility {

/// Coordinates are taken relative to the middle of the mesh before they are rounded to floats, so that large offsets do
/// not cost precision. Both sides of a face stop rays.
class RayMesh {
 public:
  /// Borrows the mesh; builds the hierarchy with all TBB threads. Throws Error with Embree's reason.
  explicit RayMesh(const Mesh& mesh);
  double build_s() const { return build_s_; }

  /// The depth z of the first intersection on the ray through every pixel centre of the frame that shows something of
  /// the photo; infinity without one. Row-major. Returns how many rays were traced. TBB.
  std::size_t first_depths(const PreparedView& view, const Pose& pose, std::vector<float>& depths) const;

  /// A point whose visibility from a camera centre is tested.
  struct Target {
    double x = 0, y = 0, z = 0;  ///< from the camera centre, along the world's axes
    bool wanted = false;
    bool visible = false;  ///< set by trace(): no intersection lies more than the bias in front of the point
  };
  /// A vertex of the mesh as a target, with both ends of the ray rounded as in the hierarchy.
  Target target(const WorldPoint& vertex, const Pose& pose) const;
  /// \pre at most 16 targets
  void trace(const Pose& pose, double epsilon, std::span<Target> targets) const;

 private:
  struct Scene;
  std::array<float, 3> relative(const WorldPoint& p) const;

  std::shared_ptr<Scene>
      scene_;  ///< shared, as its type is complete in one source alone; copies trace the same hierarchy
  WorldPoint origin_;
  double build_s_ = 0;
};

}  // namespace gpvc::visibility
