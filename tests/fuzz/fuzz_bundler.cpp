#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(bundler) { return parse_scene("Bundler", "bundle.out", data, size); }

}  // namespace gpvc::fuzz
