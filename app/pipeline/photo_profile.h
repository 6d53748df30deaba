// The colour profile that photos and pages share.
#pragma once

#include "app/cli/console.h"
#include "app/cli/scene_input.h"

namespace gpvc::pipeline {

/// The first used photo's, empty for none; a warning names photos that carry another, as colours are not converted.
/// Reads headers alone. Throws InputError.
io::ColorProfile profile_of_photos(const cli::SceneInputData& input, cli::Console& console);

}  // namespace gpvc::pipeline
