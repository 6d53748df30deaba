#include "fuzz.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(obj) {
  const auto file = folder() / "mesh.obj";
  return reads_or_refuses([&] { io::read_obj(file, view(data, size)); });
}

}  // namespace gpvc::fuzz
