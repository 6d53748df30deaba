#include "fuzz.h"
#include "io/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gpvc;
  const auto parts = fuzz::halves(fuzz::view(data, size));
  fuzz::write("cameras.txt", parts[0]);
  fuzz::write("images.txt", parts[1]);
  return fuzz::reads_or_refuses([] { read_colmap(fuzz::folder()); });
}
