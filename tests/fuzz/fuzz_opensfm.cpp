#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(opensfm) { return parse_scene("OpenSfM", "reconstruction.json", data, size); }

}  // namespace gpvc::fuzz
