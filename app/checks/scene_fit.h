// Whether photos, poses and mesh belong together, from what every view shows: noted, warned of or refused.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "../../io/image.h"
#include "../../io/tie_points.h"
#include "../../labeling/labeling.h"
#include "../../visibility/result.h"
#include "fit_verdict.h"
#include "input.h"
#include "mesh_fit.h"
#include "tie_point_fit.h"

namespace gpvc::checks {

/// Of the faces of a mesh: one of which photos see less lies in other coordinates, as a rule.
inline constexpr double kLeastSeen = 0.05;

/// What a view tells of the fit.
struct ViewFit {
  bool sees_faces = false;
  FitGroups tie_points{};
  SmallPhoto preview{};  ///< of photos that are compared, else empty
};

/// Looks at views for that. Borrows what it is given.
class FitLook {
 public:
  /// \param among the views of which some are compared, ascending
  FitLook(const Input& input, std::vector<io::TiePoint> points, std::span<const ViewId> among)
      : tie_points_(input, std::move(points)), among_(among) {}
  /// True for views whose photos are compared: their ViewFit has a preview.
  bool compares(ViewId id) const;
  /// O(pixels).
  ViewFit at(ViewId id, const Image& photo, const visibility::ViewVisibility& visible) const;
  std::span<const io::TiePoint> points() const { return tie_points_.points(); }

 private:
  TiePointFit tie_points_;
  std::span<const ViewId> among_;
};

/// What all views tell.
struct FitEvidence {
  explicit FitEvidence(std::size_t views) : sees_faces(views, 0), previews(views) {}
  void add(ViewId id, ViewFit view);
  std::vector<std::uint8_t> sees_faces;  ///< per view
  std::vector<SmallPhoto> previews;      ///< per view
  FitGroups tie_points{};
  std::span<const io::TiePoint> points{};  ///< all tie points of the scene; borrowed
};

/// What is textured all the same.
struct Tolerance {
  bool odd_views = false;  ///< photos that agree with the others by chance: nothing is said of leaving them out
  bool misfit = false;     ///< scenes where most photos do, or whose mesh is not where photos show it
  bool unseen = false;     ///< meshes of which photos see less than kLeastSeen
};

/// The numbers of faces tagged seen, partial, unseen and background.
std::array<std::size_t, 4> count_tags(std::span<const labeling::FaceTag> tags);

struct SceneFit {
  MeshFit photos;      ///< to the photos
  MeshFit tie_points;  ///< to the scene's tie points, where it has any
};

/// What is judged. Borrows everything.
struct SceneCase {
  const Input& input;
  const labeling::Candidates& candidates;
  const FitEvidence& evidence;
  Tolerance tolerance;
};

/// O(candidates).
SceneFit measure_scene(const SceneCase& scene);

/// Reports what was found. Throws InputError where nearly no face is seen, most photos agree with the others no better than
/// chance, or a common mistake explains why the mesh is not where photos show it; warns of less. \param fit empty: not
/// measured
void judge_scene(const SceneCase& scene, const std::optional<SceneFit>& fit, results::Observer& observer);

}  // namespace gpvc::checks
