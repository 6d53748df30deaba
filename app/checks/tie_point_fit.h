// Compares a mesh with the points that photogrammetry found beside the cameras.
#pragma once

#include <span>
#include <vector>

#include "../../io/tie_points.h"
#include "../../visibility/result.h"
#include "fit_verdict.h"
#include "input.h"

namespace gpvc::checks {

/// A scene's points, or as many of them as are worth comparing; a broken file is warned of. Warns of cameras whose photos show
/// the points elsewhere than they do, by how much and which way.
std::vector<io::TiePoint> read_tie_points(const Scene& scene, results::Observer& observer);

/// Tells whether a scene's tie points lie on the mesh: at most two pixels of a view that shows them in front of it or
/// behind it, along the line of sight of another. Needs no photo, and judges a mesh where photos alone cannot, as they
/// agree about a level ground wherever a mesh slides along it.
class TiePointFit {
 public:
  /// Borrows the input.
  TiePointFit(const Input& input, std::vector<io::TiePoint> points);
  /// Counts the points that are the view's. O(their number).
  FitGroups counts(ViewId view, const visibility::Ivm& ivm) const;
  std::span<const io::TiePoint> points() const { return points_; }

 private:
  Input input_;
  std::vector<io::TiePoint> points_;  ///< ascending by their first view
};

}  // namespace gpvc::checks
