// Classes compared with those of the exact oracle, on the user's own scene.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "app/evaluate/json.h"
#include "io/progress.h"
#include "io/scene.h"
#include "visibility/oracle.h"
#include "visibility/result.h"

namespace gpvc::evaluate {

/// Pairs of view and face by the oracle's class and the one found. Faces on whose class an exact tie has a say are
/// counted apart.
struct Confusion {
  /// Rows: the oracle's hidden, partial, full; columns: found hidden, partial, full, unresolved.
  std::array<std::array<std::size_t, 4>, 3> pairs{};
  std::size_t tied = 0, tied_differing = 0;

  void add(std::span<const visibility::FaceClass> found, const visibility::OracleView& truth);

  /// Found and wrong: a face left unresolved on request is neither right nor wrong.
  std::size_t disagreements() const;
  // Below, unresolved counts as hidden: like a hidden face it offers no texture.
  /// Of the pairs the oracle gives this class, the share that was found to have it; 1 where there are none.
  double share(visibility::FaceClass of) const;
  double accuracy() const;
  /// Of the pairs found to be full, the share that are not.
  double false_full() const;
  /// Of the pairs that are full, the share not found to be.
  double missed_full() const;
  Json agreement_json() const;
};

/// The oracle's classes of at most `count` of the used views, drawn at random but always the same.
std::map<ViewId, visibility::OracleView> oracle_views(const Mesh& mesh, const Scene& scene,
                                                      std::span<const ViewId> used, std::size_t count,
                                                      const Progress& progress);

/// `--oracle-check`: disagreements in some views, for people and as oracle.json.
class OracleCheck {
 public:
  OracleCheck(std::span<const ViewId> used, std::size_t count);
  /// Compares the classes of a view, if it is one of those that were drawn.
  void compare(const Mesh& mesh, const Scene& scene, ViewId id, std::span<const visibility::FaceClass> classes);

  std::size_t views() const { return views_.size(); }
  std::size_t disagreements() const { return confusion_.disagreements(); }
  /// Confusion matrix, ties apart, the first disagreements.
  std::string report() const;
  /// oracle.json.
  Json json() const;

 private:
  struct Disagreement {
    std::string view;
    std::size_t face;
    visibility::FaceClass found, truth;
    double x, y;  ///< the centroid in the frame, NaN behind the camera
  };
  std::vector<ViewId> drawn_;
  std::vector<Json> views_;
  std::vector<Disagreement> first_;
  Confusion confusion_;
  std::size_t faces_ = 0, samples_ = 0;
  double seconds_ = 0;
};

}  // namespace gpvc::evaluate
