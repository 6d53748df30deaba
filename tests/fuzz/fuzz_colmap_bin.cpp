#include "fuzz.h"
#include "io/scenes/colmap_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(colmap_bin) {
  const auto parts = halves(view(data, size));
  return reads_or_refuses(
      [&] { io::parse_colmap(true, folder() / "cameras.bin", parts[0], folder() / "images.bin", parts[1]); });
}

}  // namespace gpvc::fuzz
