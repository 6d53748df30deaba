#include "fuzz.h"
#include "io/scenes/opensfm_scene.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(odm_shots) {
  const auto parts = halves(view(data, size));
  return reads_or_refuses(
      [&] { io::parse_odm_shots(folder() / "shots.geojson", parts[0], folder() / "cameras.json", parts[1]); });
}

}  // namespace gpvc::fuzz
