// The colour profile that photos and pages share.
#pragma once

#include "app/console.h"
#include "app/scene_input.h"

namespace gpvc {

/// The first used photo's, empty for none; a warning names photos that carry another, as colours are not converted.
/// Reads headers alone. Throws InputError.
ColorProfile profile_of_photos(const SceneInputData& input, Console& console);

}  // namespace gpvc
