// True orthophotos: a textured mesh seen straight from above.
#pragma once

#include "app/ortho/frame.h"
#include "app/ortho/grid.h"

namespace gpvc::ortho {

inline constexpr const char* kOrthoFile = "ortho.tif";
inline constexpr const char* kBandsFile = "ortho_bands.tif";
inline constexpr const char* kHeightFile = "ortho_height.tif";
inline constexpr const char* kPhotoFile = "ortho_photo.tif";
inline constexpr const char* kPhotoListFile = "ortho_photos.csv";

/// Writes the orthophoto with its heights, all bands of photos that have more than RGB of 8 bits, and, where they are known, the numbers of the photos that it shows with their names. The
/// surface is in the coordinates of the frame. Tiles are drawn in rows, so that memory grows with the width alone; pixels are the same
/// for any number of threads. Throws InputError as grid_of() and plan_points(), OutputError.
void write_ortho(const Surface& surface, const PageStore& pages, const Frame& frame, const OrthoSettings& settings,
                 pipeline::OutputFolder& folder, pipeline::Observer& observer);

}  // namespace gpvc::ortho
