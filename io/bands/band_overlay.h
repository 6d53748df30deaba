// Bands of another file laid over a photo.
#pragma once

#include <cstddef>
#include <optional>

#include "io/bands/band_photo.h"

namespace gpvc::io {

/// Writes the bands of a file into `all`, from its band `first_band` on. Returns where the file shows nothing, or nothing that could be
/// interpolated without pixels that have no data; nullopt: it shows all. \param camera where the file lies instead of where
/// BandPlace::file_from_photo says; or null \pre all has room for them
std::optional<PhotoExclusion> lay_over(const StoredPhoto& file, const BandPlace& place, const BandCamera* camera,
                                       std::size_t first_band, Samples& all);

}  // namespace gpvc::io
