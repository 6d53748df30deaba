// What files say of their bands.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/samples.h"

namespace gpvc::io {

/// Names, centre wavelengths and units by GDAL's metadata, or else by XMP's Camera:BandName and Camera:CentralWavelength
/// (https://github.com/micasense/imageprocessing: Parrot, MicaSense, Sentera and DJI write them), one for each of the channels,
/// empty where nothing is known; no bands where none has a name. O(bytes).
std::vector<Band> bands_of_tags(std::string_view gdal_metadata, std::string_view xmp, std::size_t channels);

/// What PNGs call a text that is GDAL's metadata.
inline constexpr const char* kBandsKeyword = "GDALMetadata";

/// Names, wavelengths and units of the bands as bands_of_tags() finds them in GDAL's metadata.
std::string metadata_of(const BandSet& set);

/// True if what a file says of a channel in an alpha's place makes it a band: a wavelength, or a name other than an alpha's, a mask's or
/// a number's, which programs give to alphas as well ("Band 4").
bool names_band(const Band& band);

/// True if the file says of all of its channels that they are bands: then none of them is an alpha, whatever its place.
bool name_all(const std::vector<Band>& bands, int channels);

}  // namespace gpvc::io
