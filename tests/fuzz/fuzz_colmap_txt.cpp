#include "fuzz.h"
#include "io/colmap_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gpvc;
  const auto parts = fuzz::halves(fuzz::view(data, size));
  return fuzz::reads_or_refuses([&] {
    parse_colmap(false, fuzz::folder() / "cameras.txt", parts[0], fuzz::folder() / "images.txt", parts[1]);
  });
}
