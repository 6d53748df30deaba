#include "fuzz.h"
#include "io/textured_model.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(textured_obj) {
  const auto parts = halves(view(data, size));
  const auto file = write("model.obj", parts[0]);
  write("model.mtl", parts[1]);
  return reads_or_refuses([&] { io::read_textured_model(file); });
}

}  // namespace gpvc::fuzz
