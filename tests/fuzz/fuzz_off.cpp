#include "fuzz.h"
#include "io/mesh.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(off) {
  if (!io::is_off(view(data, size))) return 0;  // read_mesh would take it for an OBJ, which has a target of its own
  const auto file = write("mesh.off", view(data, size));
  return reads_or_refuses([&] { io::read_mesh(file); });
}

}  // namespace gpvc::fuzz
