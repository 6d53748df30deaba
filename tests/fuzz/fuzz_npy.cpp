#include "fuzz.h"
#include "io/npy.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(npy) {
  const auto file = write("array.npy", view(data, size));
  return reads_or_refuses([&] { io::read_npy<std::uint32_t>(file); });
}

}  // namespace gpvc::fuzz
