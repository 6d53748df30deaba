// Predicates on edge values and depths with the answers of real arithmetic on the projected vertices. Each tries a
// floating-point filter first, then ties that doubles represent without rounding, then a filter in pairs of doubles, and at
// last expansions (Shewchuk 1997), which always decide.
#pragma once

#include "visibility/raster/raster.h"

namespace gpvc::visibility {

/// A face and a position of the undistorted frame, with the edge values there.
struct FacePoint {
  const RasterFace* face;
  double px, py;
  EdgeValues values;
  double error;  ///< upper bound of the error of each edge value
};

FacePoint face_point(const RasterFace& face, double px, double py);

/// LEF and TLR, decided exactly. The face must not be edge-on.
bool covers_exactly(const FacePoint& point);

/// Order of the depths of two faces that both cover the same position: negative when f is nearer, 0 on an exact tie.
int compare_depth_exactly(const FacePoint& f, const FacePoint& g);

}  // namespace gpvc::visibility
