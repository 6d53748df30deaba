// Which samples are black and white in what is looked at.
#pragma once

#include <vector>

#include "io/bands/band_photo.h"

namespace gpvc::io {

/// Some of a photo's samples, evenly from all of it and from all bands, without those of excluded pixels.
std::vector<float> some_samples(const BandPhoto& photo);

/// Sets BandSet::black and white from samples of several photos. 8 bits keep 0 to 255. Colours keep what their files can hold, 0 to 65535,
/// where 99.98 % of the samples spread over a quarter of it: what is dark in such photos is dark. Else, of quantities and of 12 bits in
/// 16, the range is that of 99.8 % of the samples and a twentieth more on both sides, so that neither a few defects nor photos that were
/// not looked at spoil it, not below 0 unless samples are: reflectance is rarely near 1, and what is looked at has 8 bits for all of it.
/// Linear light keeps 0 to 1 unless more than half of it is brighter.
void set_range(BandSet& set, std::vector<float> samples, bool linear_light);

}  // namespace gpvc::io
