// What bands are called, and what follows from it.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/images/image_file.h"
#include "io/samples.h"

namespace gpvc::io {

/// The bands of a photo's file, without its alpha: named by its tags; else Red, Green, Blue where the file says that it holds colours, or
/// holds three (GDAL writes colours of 16 bits like that);
/// else B1, B2, from `first` + 1 on.
std::vector<Band> bands_of_file(const PhotoHeader& header, std::size_t bands, std::size_t first);

/// Makes names unique: a second "Red" becomes "Red 2".
void make_unique(std::vector<Band>& bands);

/// The bands that are looked at as red, green and blue: those called so; else near infrared, red, green; else the first three, or the first
/// one as grey.
std::array<std::size_t, 3> usual_composite(std::span<const Band> bands);

/// By names, in any case of letters, or numbers from 1 on; one for grey. Throws InputError, which names `source`.
std::array<std::size_t, 3> composite_of_names(const std::filesystem::path& source, std::span<const std::string> wanted,
                                              std::span<const Band> bands);

/// True for floats, for more than four bands, for one band of more than 8 bits, and for bands with a unit or a wavelength, or called
/// after one beyond the visible: infrared, red edge, thermal.
bool holds_quantities(const BandSet& set);

}  // namespace gpvc::io
