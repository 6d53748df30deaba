#include "fuzz.h"
#include "io/scenes/colmap_points.h"

namespace gpvc::fuzz {

// The first byte says whether text follows.
GPVC_FUZZ_TARGET(colmap_points) {
  if (size == 0) return 0;
  const bool binary = data[0] != 't';
  return reads_or_refuses([&] {
    io::parse_colmap_points(binary, folder() / (binary ? "points3D.bin" : "points3D.txt"), view(data + 1, size - 1),
                            [](std::uint64_t, const WorldPoint&, std::span<const std::uint32_t>) {});
    io::parse_colmap_sightings(binary, folder() / (binary ? "images.bin" : "images.txt"), view(data + 1, size - 1),
                               [](std::uint32_t, std::uint64_t, const PhotoPoint&) {});
  });
}

}  // namespace gpvc::fuzz
