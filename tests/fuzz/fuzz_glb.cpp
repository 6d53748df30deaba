#include "fuzz.h"
#include "io/textured_model.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(glb) {
  const auto file = write("model.glb", view(data, size));
  return reads_or_refuses([&] { io::read_textured_model(file); });
}

}  // namespace gpvc::fuzz
