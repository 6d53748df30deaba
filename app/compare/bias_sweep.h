// The biases that a comparison tries where none are given.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/scene.h"

namespace gpvc::compare {

/// What an epsilon means in a scene. A bias that bridges a share s of the median depth is s * per_share() in what the
/// method compares: lengths along a ray, or depths in the window.
class BiasScale {
 public:
  /// From the depths of vertices that lie in the frames of some of the used views.
  BiasScale(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used);
  double per_share(const std::string& family) const;
  /// Powers of ten, the same ones for similar scenes: from the rounding of the depths compared, where surfaces hide
  /// themselves, to the one nearest a hundredth of the median depth, where hidden surfaces are seen. The best bias lies
  /// between.
  std::vector<double> sweep(const std::string& family) const;

 private:
  double depth_ = 1;       ///< the median
  double spc_factor_ = 1;  ///< window depth under SPC is offset - spc_factor / z; the median over views
};

}  // namespace gpvc::compare
