#include "fuzz.h"
#include "io/io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gpvc;
  const auto parts = fuzz::halves(fuzz::view(data, size));
  const auto file = fuzz::write("model.obj", parts[0]);
  fuzz::write("model.mtl", parts[1]);
  return fuzz::reads_or_refuses([&] { read_textured_model(file); });
}
