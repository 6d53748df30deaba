// What a view adds to the coarse colours of faces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/baking/baking.h"
#include "atlas/blending/blend_weights.h"
#include "atlas/blending/coarse_photo.h"
#include "io/vector.h"

namespace gpvc::atlas {

/// Texels along the edge of a cell of the grid on which sums are kept: a pixel of a coarse photo, where texels are as fine as
/// the photo's pixels. Larger texels need no finer grid; where places are given, each cell then is a mean over its square.
inline constexpr int kBlendStep = kCoarsePixel;

/// For faces of a plain chart, one after the other.
class FaceShare {
 public:
  /// Borrows all. \param step see lattice_step \param faces how many there are, about
  FaceShare(const AtlasBuild& build, const Chart& chart, ViewId id, const CoarseRows& coarse, int step,
            std::size_t faces);

  /// Begins with a face. False if the view adds nothing to it.
  bool prepare(std::uint32_t face);
  /// Adds to the sums of cells in a row, the first of which has its middle at (x, y), in texels; to those beyond the face what
  /// the view shows at its border. \pre prepare()
  void add_row(double x, double y, std::span<ColorSum> sums) const;

 private:
  /// A vertex in the view.
  struct Corner {
    std::uint32_t vertex = kNoVertex;
    bool has_share = false;
    bool is_placed = false;  ///< the rest is known
    bool is_shown = false;
    CellFactor at;     ///< of the coarse colours
    PhotoPoint photo;  ///< if it is shown
    /// (x w, y w, w) of its position (x, y) in the frame, w being its depth by that in the main view, or its depth alone where
    /// places are given: between the corners of a face such triples are linear in the texels.
    WorldPoint frame;
  };
  static constexpr std::uint32_t kNoVertex = 0xFFFFFFFFu;
  /// Weights of the second and third corner.
  struct Weights {
    double b = 0, c = 0;
    bool is_inside() const { return b >= 0 && c >= 0 && b + c <= 1; }
    Weights clamped() const;
  };

  const Corner& corner(std::uint32_t vertex);
  Corner place(std::uint32_t vertex, const BlendWeights::Share& share) const;
  double interpolation_error() const;
  int samples_along_cell(double texels) const;
  /// As add_row() with a sample for each cell, at the same place of all of them.
  void add_samples(double x, double y, std::span<ColorSum> sums) const;
  std::optional<PhotoPoint> position(const Weights& at) const;
  CellFactor factor(const Weights& at) const;

  const AtlasBuild& build_;
  const View &view_, &main_;
  bool given_;  ///< Chart::given
  std::uint32_t number_, main_number_;
  const CoarseRows& coarse_;
  double lens_error_;         ///< of interpolation over a pixel
  std::vector<Corner> seen_;  ///< the last vertices, by the lowest bits of their numbers
  std::array<Corner, 3> corners_;
  Weights begin_, per_x_, per_y_;  ///< at texel (0, 0), and what a texel adds
  int samples_ = 1;                ///< along each edge of a cell
  bool is_affine_ = false;
  std::size_t stretch_ = 1;  ///< cells of a row between which positions are interpolated
};

}  // namespace gpvc::atlas
