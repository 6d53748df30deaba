#include "fuzz.h"
#include "io/mesh.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(ply) {
  const auto file = write("mesh.ply", view(data, size));
  return reads_or_refuses([&] { io::read_mesh(file); });
}

}  // namespace gpvc::fuzz
