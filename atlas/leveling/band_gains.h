// Gains of bands that are quantities.
#pragma once

#include <vector>

#include "atlas/atlas.h"

namespace gpvc::atlas {

/// An exposure per view for each three bands, as fit_exposure() finds it from what both photos along the seams hold in these bands, for
/// BandPainting::gains. Multiplied by them, nothing becomes negative. The coarse samples of each photo are fetched once for each
/// three bands. \pre the scene has bands
std::vector<std::vector<ViewExposure>> fit_band_gains(const AtlasInput& input);

}  // namespace gpvc::atlas
