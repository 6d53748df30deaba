#include "fuzz.h"
#include "io/mesh.h"
#include "io/textured_model.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(glb) {
  const auto file = write("model.glb", view(data, size));
  const int result = reads_or_refuses([&] { io::read_textured_model(file); });
  reads_or_refuses([&] { io::read_mesh(file); });
  return result;
}

}  // namespace gpvc::fuzz
