// What files say of their bands.
#pragma once

#include <string_view>
#include <vector>

#include "io/samples.h"

namespace gpvc::io {

/// Names, centre wavelengths and units by GDAL's metadata, or else by XMP's Camera:BandName and Camera:CentralWavelength
/// (https://github.com/micasense/imageprocessing: Parrot, MicaSense, Sentera and DJI write them), one for each of the channels,
/// empty where nothing is known; no bands where none has a name. O(bytes).
std::vector<Band> bands_of_tags(std::string_view gdal_metadata, std::string_view xmp, std::size_t channels);

}  // namespace gpvc::io
