#include <fstream>

#include "app/cli/options.h"
#include "silence.h"
#include "tiny_job.h"

namespace gpvc::fuzz {
namespace {

std::vector<std::string> listing_seeds(const std::filesystem::path&) { return {read(tiny_job() / "job.json")}; }

}  // namespace

// `gpvc plan`. (plan.json is for other programs: this one reads none.)
GPVC_FUZZ_TARGET(job_json, listing_seeds) {
  const std::filesystem::path file = tiny_job() / "job.json";
  static const std::string kGood = read(file);
  std::ofstream(file, std::ios::binary) << view(data, size);
  const Silence silence;
  cli::Console console(cli::Loudness::quiet, {});
  succeeds_or_fails([&] { cli::run_plan({{}, tiny_job(), size % 2 == 0}, console); });
  std::ofstream(file, std::ios::binary) << kGood;
  return 0;
}

}  // namespace gpvc::fuzz
