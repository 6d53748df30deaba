// Where an item buffer jumps in depth, and the strip around it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "io/scene.h"
#include "visibility/visibility.h"

namespace gpvc::labeling {

/// Inverse depth of a face's plane, which is affine in the pixel: 1/z = x * (px - cx) + y * (py - cy) + constant. In
/// float: the threshold it is compared with is relative and some 1e-3, float's step 1e-7.
struct InverseDepth {
  float x = 0, y = 0, constant = 0;
  float at(float px, float py) const { return x * px + y * py + constant; }
};

/// The plane of a triangle given in camera coordinates. A triangle seen edge-on has none: all zero.
InverseDepth inverse_depth(const Camera& camera, const CameraPoint (&corners)[3]);

/// One byte a pixel, 1 within `margin_px` pixels of a depth discontinuity, on both sides of it (what is behind gets the
/// colour of what is in front, and the other way round, wherever photo and mesh disagree).
///
/// Two neighbouring pixels of different faces lie across one when the faces' planes, both evaluated at both pixels, do
/// not meet between them and remain apart by more than `margin_px` footprints of a pixel (z / f). A smaller step moves
/// the surface by less than the disagreement that the margin is there for. A pixel in the photo that shows no face at
/// all (sky) is a discontinuity too; one outside the photo is not. `plane_of` must be callable from several threads.
/// O(pixels * (1 + margin)), TBB inside.
std::vector<std::uint8_t> silhouette_margin(const Camera& camera, const visibility::Ivm& ivm, int margin_px,
                                            const std::function<InverseDepth(FaceId)>& plane_of);

}  // namespace gpvc::labeling
