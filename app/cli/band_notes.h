// What is said of photos with more than RGB of 8 bits.
#pragma once

#include <string>
#include <vector>

#include "app/evaluate/json.h"
#include "io/scene.h"

namespace gpvc::cli {

using evaluate::Json;

/// What the bands are, what is looked at, and where bands in files of their own lie; nothing where photos have none.
std::vector<std::string> band_notes(const Scene& scene);

/// The same in run.json; null where photos have none.
Json bands_json(const Scene& scene);

}  // namespace gpvc::cli
