#include <fstream>

#include "tiny_job.h"

namespace gpvc::fuzz {
namespace {

const std::vector<JobFile> kDoneLists{{"units/level/done.json", {"bake-0-0", "finish"}},
                                      {"units/bake-0-0/done.json", {"finish"}},
                                      {"mesh/done.json", {"cost-0-0"}},
                                      {"mesh/files.json", {"cost-0-0"}}};

std::vector<std::string> list_seeds(const std::filesystem::path&) { return job_seeds(kDoneLists, read); }

}  // namespace

// What is written once a unit is complete.
GPVC_FUZZ_TARGET(done, list_seeds) {
  const Choice list = choice_of(view(data, size), kDoneLists.size());
  return run_readers(kDoneLists[list.number],
                     [&](const std::filesystem::path& file) { std::ofstream(file, std::ios::binary) << list.body; });
}

}  // namespace gpvc::fuzz
