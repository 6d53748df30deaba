#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(openmvs) { return parse_scene("OpenMVS", "scene.mvs", data, size); }

}  // namespace gpvc::fuzz
