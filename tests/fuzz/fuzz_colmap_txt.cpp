#include "fuzz.h"
#include "io/scenes/colmap_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(colmap_txt) {
  const auto parts = halves(view(data, size));
  return reads_or_refuses(
      [&] { io::parse_colmap(false, folder() / "cameras.txt", parts[0], folder() / "images.txt", parts[1]); });
}

}  // namespace gpvc::fuzz
