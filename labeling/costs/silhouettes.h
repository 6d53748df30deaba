// Finds depth discontinuities of an IVM, and the strip of pixels around them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "io/scene.h"
#include "visibility/visibility.h"

namespace gpvc::labeling {

/// Inverse depth of a face's plane, which is affine in the pixel: 1/z = x * (px - cx) + y * (py - cy) + constant. Floats
/// suffice: they round by 1e-7, and the relative threshold for depths is some 1e-3.
struct InverseDepth {
  float x = 0, y = 0, constant = 0;
  float at(float px, float py) const { return x * px + y * py + constant; }
};

using CameraTriangle = std::array<CameraPoint, 3>;

CameraTriangle camera_corners(const Mesh& mesh, std::size_t face, const Pose& pose);

/// Normal of a triangle, of twice the triangle's area: (b - a) x (c - a).
CameraPoint area_normal(const CameraTriangle& corners);

/// The plane of a triangle given in camera coordinates. All zero for a triangle seen edge-on, which has none.
InverseDepth inverse_depth(const Camera& camera, const CameraTriangle& corners);

/// One byte a pixel, 1 within `margin_px` pixels of a depth discontinuity, on both sides of it: wherever photo and mesh
/// disagree, the surface behind gets the colour of the one in front or the other way round.
///
/// There is a discontinuity between two neighbouring pixels of different faces if the faces' planes, both evaluated at
/// both pixels, do not intersect between them and remain apart by more than `margin_px` pixel footprints (z / f). A
/// smaller step displaces the surface by less than the disagreement that the margin covers. A pixel in the photo without
/// a face (sky) makes a discontinuity, too; a pixel outside the photo does not. `plane_of` is called by several threads at
/// a time. O(pixels * (1 + margin)), TBB inside.
std::vector<std::uint8_t> silhouette_margin(const Camera& camera, const visibility::Ivm& ivm, int margin_px,
                                            const std::function<InverseDepth(FaceId)>& plane_of);

}  // namespace gpvc::labeling
