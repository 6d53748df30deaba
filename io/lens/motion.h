// A camera that moves while its photo is read out: the formulas of Motion in scene.h.
#pragma once

#include "io/scene.h"

namespace gpvc::io {

/// When the place of the photo was read out.
double time_of(const Camera& camera, const PhotoPoint& p);

/// Where the lens sees, at a time, what lies at (x, y, 1) in the camera's axes at time 0; of any length.
CameraPoint moved(const Motion& motion, double time, double x, double y);

/// Its inverse: (x, y, 1) at time 0 of what lies at (x, y, 1) at a time; of any length.
CameraPoint moved_back(const Motion& motion, double time, double x, double y);

/// Bounds for the frame up to a squared radius r2 of the undistorted plane, at times from -1/2 to 1/2 for each of
/// Motion::across and down.
struct MotionBounds {
  double r2;       ///< of the moved points
  double stretch;  ///< of |d moved / d unmoved|, both on the plane z = 1
  double speed;    ///< of |d moved / d time| on that plane
};
/// All infinite where points may move beside or behind the camera.
MotionBounds motion_bounds(const Motion& motion, double r2);

}  // namespace gpvc::io
