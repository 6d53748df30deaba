// Predicates on edge values and depths whose answers are those of real arithmetic on the projected vertices: a
// floating-point filter first, then what doubles hold without rounding, long double, and expansions (Shewchuk 1997)
// when none of these can tell.
#pragma once

#include "visibility/raster/raster.h"

namespace gpvc::visibility {

/// A face and a position of the undistorted frame (a pixel centre, or any other), with the edge values there.
struct FacePoint {
  const RasterFace* face;
  double px, py;
  EdgeValues values;
  double error;  ///< no edge value is further than this from its real value
};

FacePoint face_point(const RasterFace& face, double px, double py);

/// LEF and TLR, decided exactly. The face must not be edge-on.
bool covers_exactly(const FacePoint& point);

/// Order of the depths of two faces that both cover the same position: negative when f is nearer, 0 on an exact tie.
int compare_depth_exactly(const FacePoint& f, const FacePoint& g);

}  // namespace gpvc::visibility
