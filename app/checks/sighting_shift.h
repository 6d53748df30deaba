// Compares where photos show a scene's tie points with where its cameras do.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "../../io/tie_points.h"

namespace gpvc::checks {

/// Views of one camera whose photos show points shifted, or farther from the middle or nearer to it.
struct SightingShift {
  ViewId view{};          ///< the first of them
  std::size_t views = 0;  ///< their number
  double right = 0;       ///< of where the camera shows the points, in pixels of the view
  double down = 0;
  double growth = 0;  ///< of the distance from the principal point, -0.2 for a fifth less; then there is no shift
};

/// The shifts of a pixel of the whole photo and more, by camera: of principal points that were edited, or that a crop or
/// another convention moved; and growth of 1 % and more: of focal lengths that were. Photogrammetry leaves a tenth of a pixel, as
/// it moves both until nothing is left. O(sightings log sightings).
std::vector<SightingShift> sighting_shifts(const Scene& scene, std::span<const io::Sighting> sightings);

/// "a.jpg and 13 more show their tie points 12.0 pixels below where their camera does: ...", or "... 16.7 % nearer to the
/// principal point than ..."
std::string shift_text(const Scene& scene, const SightingShift& shift);

}  // namespace gpvc::checks
