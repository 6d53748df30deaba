#include "fuzz.h"
#include "labeling/labeling.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(costs) {
  const auto file = write("costs.spt", view(data, size));
  return reads_or_refuses([&] { labeling::read_costs(file); });
}

}  // namespace gpvc::fuzz
