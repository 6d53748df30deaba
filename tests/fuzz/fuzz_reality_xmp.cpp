#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(reality_xmp) { return parse_scene("RealityCapture", "one.xmp", data, size); }

}  // namespace gpvc::fuzz
