#include "fuzz.h"
#include "io/colmap_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gpvc;
  const auto parts = fuzz::halves(fuzz::view(data, size));
  return fuzz::reads_or_refuses([&] {
    parse_colmap(true, fuzz::folder() / "cameras.bin", parts[0], fuzz::folder() / "images.bin", parts[1]);
  });
}
