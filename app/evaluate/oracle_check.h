// Classes compared with those of the exact oracle, on the user's own scene.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "app/evaluate/json.h"
#include "io/progress.h"
#include "io/scene.h"
#include "visibility/oracle.h"
#include "visibility/visibility.h"

namespace gpvc::evaluate {

/// The first `count` of the used views in a shuffle that depends on the seed alone, ascending; all if there are fewer.
std::vector<ViewId> draw_views(std::span<const ViewId> used, std::size_t count, std::uint32_t seed);

/// Pairs of view and face by the oracle's class and the one found. Faces on whose class an exact tie has a say are
/// counted apart.
struct Confusion {
  /// Rows: the oracle's hidden, partial, full; columns: found hidden, partial, full, unresolved.
  std::array<std::array<std::size_t, 4>, 3> pairs{};
  std::size_t tied = 0, tied_differing = 0;

  void add(std::span<const visibility::FaceClass> found, const visibility::OracleView& truth);
  Confusion& operator+=(const Confusion& other);

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

/// The oracle's classes of a few views, found once. One byte a face and view.
class OracleViews {
 public:
  OracleViews(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used, std::size_t count,
              const Progress& progress);
  std::size_t views() const { return views_.size(); }
  Json json(const Scene& scene) const;
  /// Adds a view's pairs, if it is one of the views.
  void compare(ViewId view, std::span<const visibility::FaceClass> classes, Confusion& confusion) const;

 private:
  struct View {
    ViewId id{};
    visibility::OracleView truth;
  };
  std::vector<View> views_;
};

/// `--oracle-check`: disagreements in some views, for people and as oracle.json.
class OracleCheck {
 public:
  OracleCheck(std::span<const ViewId> used, std::size_t count);
  bool wants(ViewId view) const;
  /// Compares the classes of a view.
  void compare(const Mesh& mesh, const View& view, std::span<const visibility::FaceClass> classes);

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
