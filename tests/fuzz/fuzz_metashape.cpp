#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(metashape) { return parse_scene("Metashape", "cameras.xml", data, size); }

}  // namespace gpvc::fuzz
