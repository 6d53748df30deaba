// Which face each pixel of a picture shows.
#pragma once

#include "result.h"

namespace gpvc::visibility {

/// Draws all faces, front and back, without OpenGL. The camera is a pinhole: its distortion is ignored, and no pixel is
/// masked. Where floats cannot order two depths, either face may be drawn. O(vertices + faces + pixels that they
/// cover), TBB.
Ivm draw_item_buffer(const Mesh& mesh, const Camera& camera, const Pose& pose);

}  // namespace gpvc::visibility
