// Points on the faces of a synthetic scene and what its photos show of them: all that is known before a model is scored.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <vector>

#include "app/evaluate/shown_photos.h"

namespace gpvc::evaluate {

/// A synthetic scene and the photos that models of it were textured from. Borrows all.
struct TruthInput {
  const Truth& truth;
  const Mesh& mesh;  ///< as it was given to the texturing; the faces are those of truth.mesh
  const Scene& scene;
  std::span<const ViewId> used;
  io::PhotoSource& photos;
};

struct FacePoint {
  std::uint32_t face = 0;
  float b = 0, c = 0;  ///< barycentric: A + b (B - A) + c (C - A)
  double area = 0;     ///< the part of the face's area that the point stands for
};

/// The colours, at an exposure of 1, that photos show of a point: from the least to the most of each channel.
struct OwnColors {
  Pixel least{1e9F, 1e9F, 1e9F}, most{-1e9F, -1e9F, -1e9F};
  Pixel sum{};
  float count = 0;
  void add(const Pixel& p);
  /// How far outside a colour lies, in the channel where that is farthest.
  double distance(const Pixel& p) const;
};

struct TruthPoints {
  std::vector<FacePoint> seen;              ///< some used photo shows them clear of other surfaces; in face order
  std::vector<OwnColors> own;               ///< per seen point
  std::vector<float> undetectable;          ///< per seen point, see TruthShares
  std::vector<FacePoint> hidden;            ///< no ray from a used photo meets them; in face order
  std::vector<float> gains;                 ///< by which a texel may differ from photos at an exposure of 1
  std::vector<visibility::FaceClass> best;  ///< per face, the best class that any used view has

  /// How far a texel is from the point's own colours, at the gain that suits it best.
  double own_distance(std::size_t point, const Pixel& texel) const;
};

/// Twice the vector area of a face.
WorldPoint twice_area_normal(const Mesh& mesh, std::size_t face);
WorldPoint position_of(const Mesh& mesh, const FacePoint& point);

/// visit(index) for each of `count` points, in parallel.
template <class Visit>
void for_each_point(std::size_t count, const Visit& visit) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1024), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) visit(i);
  });
}

}  // namespace gpvc::evaluate
