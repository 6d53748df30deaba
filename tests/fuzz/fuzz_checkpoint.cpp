#include "app/pipeline/bake_into.h"
#include "app/pipeline/checkpoint.h"
#include "app/pipeline/steps.h"
#include "app/results/output_folder.h"
#include "io/photos.h"
#include "tiny.h"

namespace gpvc::fuzz {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kKeptParts{"view-0", "view-1", "labels", "leveling", "page-0"};

fs::path kept_parts() { return folder() / "kept"; }

// All steps of gpvc texture but the files of the model.
void texture_on() {
  pipeline::StepKeys keys;
  for (const ViewId id : tiny().views) keys.views[id] = {{1, index(id)}};
  pipeline::Checkpoint checkpoint(kept_parts(), keys);
  io::PhotoCache photos(tiny().scene);
  results::Observer silent;
  const pipeline::Settings settings = tiny_settings();
  const checks::Input input = tiny().input();
  const pipeline::Run run{input, settings, photos, silent, &checkpoint};
  const pipeline::MemoryPlan memory = pipeline::plan_memory(input, settings);
  const pipeline::Choice choice = pipeline::see_and_choose(run, memory);
  pipeline::bake_into(run, pipeline::atlas_input(input, photos, choice.graph, choice.seen, choice.selection.labels),
                      memory, {.kept = checkpoint.pages()}, nullptr);
}

const Snapshot& good_parts() {
  static const Snapshot kGood = [] {
    texture_on();
    return Snapshot(kept_parts());
  }();
  return kGood;
}

std::vector<std::string> kept_seeds(const fs::path&) {
  good_parts();
  std::vector<std::string> seeds;
  for (std::size_t n = 0; n < kKeptParts.size(); ++n)
    seeds.push_back(input_for(n, stored(kept_parts() / kKeptParts[n])));
  return seeds;
}

}  // namespace

// What a run that was cut off has kept.
GPVC_FUZZ_TARGET(checkpoint, kept_seeds) {
  const Choice part = choice_of(view(data, size), kKeptParts.size());
  good_parts();
  store(kept_parts() / kKeptParts[part.number], part.body, results::kCheckpointHashes);
  succeeds_or_fails(texture_on);
  good_parts().restore();
  return 0;
}

}  // namespace gpvc::fuzz
