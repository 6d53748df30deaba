#include "tiny_job.h"

namespace gpvc::fuzz {
namespace {

const std::vector<JobFile> kJobParts{{"mesh/scene", {"see-0-0"}},
                                     {"mesh/tile-0", {"see-0-0", "judge", "cost-0-0", "bake-0-0", "simplify-1-0"}},
                                     {"units/see-0-0/views", {"judge"}},
                                     {"units/see-0-0/tile-0", {"judge", "cost-0-0"}},
                                     {"units/see-0-0/photos", {"see-0-0", "expose-0"}},
                                     {"units/judge/photos", {"cost-0-0"}},
                                     {"units/cost-0-0/costs", {"choose-0-1-0", "expose-0", "bake-0-0"}},
                                     {"units/choose-0-2-0/labels", {"expose-0", "bake-0-0"}},
                                     {"units/expose-0/relations", {"level"}},
                                     {"units/level/exposure", {"bake-0-0", "bake-1-0"}},
                                     {"units/simplify-1-0/tile", {"ring-1-0", "finish"}},
                                     {"units/ring-1-0/tile", {"see-1-0", "cost-1-0", "bake-1-0"}},
                                     {"units/level/alignment", {"bake-0-0", "bake-1-0"}}};

std::vector<std::string> part_seeds(const std::filesystem::path&) { return job_seeds(kJobParts, stored); }

}  // namespace

// What units leave for each other, under hashes that are right.
GPVC_FUZZ_TARGET(job, part_seeds) {
  const Choice part = choice_of(view(data, size), kJobParts.size());
  return run_readers(kJobParts[part.number], [&](const std::filesystem::path& file) {
    store(file, part.body);
    if (file.filename() != "photos" || file.parent_path().filename() == "judge") relist(file);
  });
}

}  // namespace gpvc::fuzz
