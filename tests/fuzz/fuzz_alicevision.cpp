#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(alicevision) { return parse_scene("AliceVision", "cameras.sfm", data, size); }

}  // namespace gpvc::fuzz
