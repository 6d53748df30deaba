#include "fuzz_scene.h"
#include "io/scenes/micmac_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(micmac) {
  const auto parts = halves(view(data, size));
  return reads_or_refuses([&] {
    expect_sound(io::parse_micmac(folder() / "Orientation-a.jpg.xml", parts[0], folder() / "AutoCal.xml", parts[1]));
  });
}

}  // namespace gpvc::fuzz
