#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(reality_csv) { return parse_scene("RealityCapture CSV", "cameras.csv", data, size); }

}  // namespace gpvc::fuzz
