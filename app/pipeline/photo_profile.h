// The colour profile that photos and pages share.
#pragma once

#include "app/pipeline/pipeline.h"

namespace gpvc::pipeline {

/// The profile of the first view's photo file, empty where it has none or there is no file. Warns of photos with another
/// profile, as colours are not converted. Reads file headers only. Throws InputError.
io::ColorProfile profile_of_photos(const Input& input, Observer& observer);

}  // namespace gpvc::pipeline
