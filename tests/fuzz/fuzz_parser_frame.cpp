#include <cmath>

#include "fuzz.h"
#include "io/scenes/parser_frame.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(parser_frame) {
  return reads_or_refuses([&] {
    const SceneFrame frame = io::parse_parser_frame(folder() / "dataparser_transforms.json", view(data, size));
    if (!(frame.scale > 0) || !std::isfinite(frame.origin.x + frame.origin.y + frame.origin.z + frame.rotation[0]))
      std::abort();
  });
}

}  // namespace gpvc::fuzz
