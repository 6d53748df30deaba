#include "fuzz_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return gpvc::fuzz::parse_scene("OpenMVS", "scene.mvs", data, size);
}
