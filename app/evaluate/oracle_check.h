// The stage's classes of some views beside those of the oracle, on the user's own scene.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "app/evaluate/json.h"
#include "io/scene.h"
#include "visibility/visibility.h"

namespace gpvc::evaluate {

class OracleCheck {
 public:
  /// Draws `count` of `used` at random, always the same ones; all if there are fewer.
  OracleCheck(const std::vector<ViewId>& used, std::size_t count);
  bool wants(ViewId view) const;
  /// Compares the classes of a view.
  void compare(const Mesh& mesh, const View& view, std::span<const visibility::FaceClass> classes);

  std::size_t views() const { return views_.size(); }
  std::size_t disagreements() const { return disagreements_; }
  /// What the user reads: confusion matrix, ties apart, the first disagreements.
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
  /// Rows are the classes found, columns the oracle's.
  using Matrix = std::array<std::array<std::size_t, 3>, 4>;

  bool any_unresolved() const;

  std::vector<ViewId> drawn_;
  std::vector<Json> views_;
  std::vector<Disagreement> first_;
  Matrix matrix_{};
  std::size_t faces_ = 0, tied_ = 0, tied_differing_ = 0, disagreements_ = 0, samples_ = 0;
  double seconds_ = 0;
};

}  // namespace gpvc::evaluate
