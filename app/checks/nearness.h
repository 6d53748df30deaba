// How far the scene lies from cameras that moved while their photos were read out.
#pragma once

#include "../../io/scene.h"

namespace gpvc::checks {

/// Sets Motion::nearness of all views that have a step: the inverse-depth plane that differs least, by the sum of squares,
/// from the inverse depths of the mesh along a grid of rays. `offset` is to be added to the mesh's positions. \pre mesh and cameras lie in
/// the same coordinates. O(moving views x framed faces)
void set_nearness(Scene& scene, const Mesh& mesh, const WorldPoint& offset = {});

}  // namespace gpvc::checks
