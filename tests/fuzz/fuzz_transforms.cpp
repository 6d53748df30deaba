#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(transforms) { return parse_scene("transforms.json", "transforms.json", data, size); }

}  // namespace gpvc::fuzz
