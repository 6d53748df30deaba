#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(nvm) { return parse_scene("NVM", "scene.nvm", data, size); }

}  // namespace gpvc::fuzz
