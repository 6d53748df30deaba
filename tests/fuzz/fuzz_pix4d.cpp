#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(pix4d) { return parse_scene("Pix4D", "p_calibrated_camera_parameters.txt", data, size); }

}  // namespace gpvc::fuzz
