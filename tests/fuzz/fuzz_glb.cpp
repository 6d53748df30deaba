#include "fuzz.h"
#include "io/io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gpvc;
  const auto file = fuzz::write("model.glb", fuzz::view(data, size));
  return fuzz::reads_or_refuses([&] { read_textured_model(file); });
}
