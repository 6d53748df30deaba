// Colours for faces that no photo shows, from around them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/baking/baking.h"

namespace gpvc::atlas {

/// Writes the charts of unseen faces: in options.unseen_color where that is wanted. Else vertex colours in each hole are
/// the harmonic function (uniform edge weights) that continues the colours on the hole's border, and within a face they
/// are interpolated linearly; a hole without a border, where a whole component of the mesh is unseen, takes the mean
/// colour of all pages.
class HoleFiller {
 public:
  explicit HoleFiller(AtlasBuild& build);

  /// True if the page has unseen faces.
  bool is_pending(std::uint32_t page) const { return pending_[page] != 0; }
  /// Keeps the colours that open pages have along the borders of holes. Call it when all other charts are finished on
  /// these pages. O(corners on borders of holes).
  void look_at_borders();
  /// Finds the colours of all holes. O(unseen faces x CG iterations). \pre the borders on all pages have been looked at
  void solve();
  /// Writes the unseen faces on open pages. \pre solve()
  void fill();

 private:
  void solve(std::size_t layer);

  AtlasBuild& build_;
  std::vector<char> pending_;         ///< per page
  std::vector<std::uint32_t> slot_;   ///< per mesh vertex: its place among those of holes, or none
  std::uint32_t vertices_ = 0;        ///< of holes
  std::vector<std::size_t> corners_;  ///< of seen faces on borders of holes that are filled, as 3 x face + corner
  /// Of one layer.
  struct Colors {
    std::vector<std::optional<Color>> border;  ///< per corner of corners_
    std::vector<Color> vertex;                 ///< per vertex of holes
  };
  std::vector<Colors> layers_;
};

}  // namespace gpvc::atlas
