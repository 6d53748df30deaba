// Bands of a synthetic scene as files.
#pragma once

#include <string>
#include <vector>

#include "app/evaluate/json.h"
#include "app/results/output_folder.h"
#include "app/synth/band_photos.h"
#include "io/scene.h"

namespace gpvc::cli {

/// Names photos as cameras with several lenses name those of the first one, NAME0001_1.tif, where bands have files of their own; else
/// NAME_001.tif.
void name_band_photos(std::vector<View>& views, const synth::BandOptions& bands);

/// The TIFF of a view, or those of its bands, in `subfolder` ("images/").
void write_bands(const Samples& samples, const std::string& subfolder, const std::string& view,
                 const synth::BandOptions& options, results::OutputFolder& folder);

/// What truth.json says of them: names, wavelengths, the sample of white, and shifts.
evaluate::Json synth_bands_json(const synth::BandOptions& options);

}  // namespace gpvc::cli
