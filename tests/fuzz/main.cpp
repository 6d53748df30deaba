#include <cstdio>
#include <cstdlib>

#include "fuzz.h"

namespace {
gpvc::fuzz::Target target = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("GPVC_FUZZ_TARGET");
  const auto found = gpvc::fuzz::targets().find(name == nullptr ? "" : name);
  if (found == gpvc::fuzz::targets().end()) {
    std::fputs("GPVC_FUZZ_TARGET: expected one of", stderr);
    for (const auto& [known, run] : gpvc::fuzz::targets()) std::fprintf(stderr, " %s", known.c_str());
    std::fputs("\n", stderr);
    std::exit(2);
  }
  target = found->second;
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { return target(data, size); }
