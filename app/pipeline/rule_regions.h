// The regions of rules about photos as parts of a mesh.
#pragma once

#include <span>
#include <string>

#include "../../io/view_rules.h"
#include "../checks/input.h"

namespace gpvc::pipeline {

/// What region_of() cannot do with a region: the end of a sentence about the rule.
class RegionError : public Error {
 public:
  using Error::Error;
};

/// The faces of which a view shows the larger part of the visible pixels in a rectangle of its photo as it was taken
/// (io::taken_pixel()), or, of those that cover no pixel, the middle. `views`: those of one photo, of each of which that counts. Draws
/// them natively. O(views (faces + pixels)).
io::FaceRegion faces_shown(const checks::Input& input, std::span<const ViewId> views, const PhotoPoint& low,
                           const PhotoPoint& high);

/// A region in the coordinates of the mesh's file as one of the mesh. O(faces log faces), TBB, where these are not the same.
io::Region region_of(const io::Region& region, const Mesh& mesh);

/// A region of the ground in the coordinates of a reference system, brought to the scene's. Longitude and latitude
/// (io::kGeoJsonSystem) are taken for the mesh's own coordinates where the scene has no reference system. Throws RegionError where
/// it cannot be brought there.
io::Region region_of(io::GroundRegion region, const std::string& srs, const checks::Input& input);

}  // namespace gpvc::pipeline
