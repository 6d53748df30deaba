#include "fuzz_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(blocks_exchange) { return parse_scene("BlocksExchange", "block.xml", data, size); }

}  // namespace gpvc::fuzz
