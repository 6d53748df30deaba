// A picture of where photos fit each other at cuts between charts, and where they do not.
#pragma once

#include <span>

#include "../../atlas/photo_alignment.h"
#include "../../io/image.h"
#include "viewpoint.h"

namespace gpvc::pipeline {

/// The preview, pale, with a dot for each place on a cut that is seen there: green where the photos on its two sides fit, over yellow
/// to red where they are 2 px apart or more. \param preview RGB, of the camera's size. O(faces + pixels + places), TBB.
Image misfit_picture(const Mesh& mesh, const Image& preview, const Viewpoint& from,
                     std::span<const atlas::CutMisfit::Place> places);

}  // namespace gpvc::pipeline
