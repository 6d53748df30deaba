// How often a mode's classes are those of the exact oracle.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "app/evaluate/json.h"
#include "io/progress.h"
#include "io/scene.h"
#include "visibility/oracle.h"
#include "visibility/visibility.h"

namespace gpvc::evaluate {

/// Pairs of view and face; faces in whose class an exact tie has a say are counted apart.
struct Agreement {
  /// Rows: the oracle's hidden, partial, full; columns: the mode's.
  std::array<std::array<std::size_t, 3>, 3> pairs{};
  std::size_t tied = 0;

  /// Of the pairs the oracle gives this class, the share that the mode gives it too; 1 where there are none.
  double share(visibility::FaceClass of) const;
  double accuracy() const;
  /// Of the pairs the mode calls full, the share that are not.
  double false_full() const;
  /// Of the pairs that are full, the share the mode does not call so.
  double missed_full() const;
  Json json() const;
};

/// The oracle's classes of a few views, found once. One byte a face and view.
class OracleViews {
 public:
  /// `count` of the used views, drawn at random, always the same ones.
  OracleViews(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used, std::size_t count,
              const Progress& progress);
  std::size_t views() const { return views_.size(); }
  std::size_t tied() const;
  Json json(const Scene& scene) const;
  /// Adds a view's pairs, if it is one of the views.
  void compare(ViewId view, const visibility::ViewVisibility& visible, Agreement& agreement) const;

 private:
  struct View {
    ViewId id{};
    visibility::OracleView truth;
  };
  std::vector<View> views_;
};

}  // namespace gpvc::evaluate
