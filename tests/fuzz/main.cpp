#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "fuzz.h"

namespace {

gpvc::fuzz::Target target;

// GPVC_FUZZ_SEEDS: a folder that gets the target's own seeds, instead of a run.
void write_seeds(const std::filesystem::path& out) {
  const char* corpus = std::getenv("GPVC_FUZZ_CORPUS");
  std::size_t number = 0;
  if (target.seeds != nullptr)
    for (const std::string& seed : target.seeds(corpus == nullptr ? "" : corpus))
      std::ofstream(out / std::to_string(number++), std::ios::binary) << seed;
  std::exit(0);
}

}  // namespace

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
  if (const char* out = std::getenv("GPVC_FUZZ_SEEDS")) write_seeds(out);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { return target.run(data, size); }
