#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(cam) { return parse_scene("mvs-texturing", "one.cam", data, size); }

}  // namespace gpvc::fuzz
