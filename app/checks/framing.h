// Which parts of a mesh a view frames.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "../../io/box.h"
#include "../../io/scene.h"

namespace gpvc::checks {

using gpvc::Box;

std::array<WorldPoint, 8> corners(const Box& box);

/// False if all points lie beyond one border of the view's frame or behind the camera, and so does their convex hull.
/// Conservative: true for some hulls just outside a corner.
bool hull_may_be_framed(const View& view, std::span<const WorldPoint> points);

/// The same of a face: true for every face inside the frame.
bool may_be_framed(const View& view, const Mesh& mesh, const Triangle& face);

/// Runs of neighbouring faces, by whose bounding boxes a view skips most of a mesh.
class FaceRuns {
 public:
  static constexpr std::size_t kRun = 1024;  ///< faces
  explicit FaceRuns(const Mesh& mesh);
  /// Calls use(begin, end) for the runs that may be framed.
  template <class Use>
  void for_each_framed(const View& view, const Use& use) const {
    for (std::size_t r = 0; r < hulls_.size(); ++r)
      if (hull_may_be_framed(view, hulls_[r])) use(r * kRun, std::min(faces_, (r + 1) * kRun));
  }

 private:
  std::size_t faces_;
  std::vector<std::array<WorldPoint, 8>> hulls_;
};

/// At most so many of the faces all over a mesh, each with vertices of its own; with a view, of those that it may frame.
/// O(faces).
Mesh some_faces(const Mesh& mesh, std::size_t most, const View* view = nullptr);

}  // namespace gpvc::checks
