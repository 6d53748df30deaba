#include "fuzz.h"
#include "io/mesh_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gpvc;
  const auto file = fuzz::folder() / "mesh.obj";
  return fuzz::reads_or_refuses([&] { read_obj(file, fuzz::view(data, size)); });
}
