#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(openmvg) { return parse_scene("OpenMVG", "sfm_data.json", data, size); }

}  // namespace gpvc::fuzz
