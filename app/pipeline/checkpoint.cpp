#include "app/pipeline/checkpoint.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <charconv>
#include <utility>

#include "app/pipeline/held_bytes.h"

namespace gpvc::pipeline {
namespace {

constexpr std::string_view kViewPart = "view-";

// How long a run must be expected to take for its work to be kept.
constexpr double kKeepSeconds = 60;

const io::WorkKey& key_of(const std::string& name, const StepKeys& keys) {
  if (!name.starts_with(kViewPart)) return keys.labels;
  std::uint32_t number = 0;
  std::from_chars(name.data() + kViewPart.size(), name.data() + name.size(), number);
  return keys.views.at(ViewId{number});
}

}  // namespace

bool Checkpoint::read(const std::string& name, const std::function<void(Reader&)>& fill) const {
  return store_.read(name, key_of(name, keys_), fill);
}

void Checkpoint::write(const std::string& name, const std::function<void(Writer&)>& fill) {
  store_.keep(name, key_of(name, keys_), fill);
}

void Checkpoint::warn_of_failure(Observer& observer) {
  const std::optional<OutputError> failure = warned_ ? std::nullopt : store_.failure();
  if (!failure) return;
  warned_ = true;
  observer.warning(
      fmt::format("{}; no more work is kept, so a run that is cut off will repeat what follows", failure->what()));
}

std::string view_part(ViewId id) { return fmt::format("{}{}", kViewPart, index(id)); }

std::optional<Checkpoint> open_checkpoint(const Run& run, const MemoryPlan& memory, const FileSizes& sizes,
                                          const OutputFolder& folder, const std::filesystem::path& part) {
  const KeepWork wanted = run.settings.keep_work;
  if (wanted == KeepWork::never) return std::nullopt;
  const Workload& work = memory.work;
  const bool earlier = folder.has_checkpoints();
  if (wanted == KeepWork::automatic && !earlier &&
      predicted_seconds(work, tbb::this_task_arena::max_concurrency()) < kKeepSeconds)
    return std::nullopt;
  if (!earlier && folder.space() < sizes.likely + kept_bytes(work)) {
    run.observer.note(fmt::format(
        "work is not kept, as that might take {} more on disk: if this run is cut off, it starts again from nothing",
        results::readable_bytes(kept_bytes(work))));
    return std::nullopt;
  }
  std::optional<StepKeys> keys = step_keys(run);
  if (!keys) return std::nullopt;
  if (!earlier)
    run.observer.note(
        fmt::format("work is kept in {} until all is done: if this run is cut off, the same command goes on from there",
                    folder.checkpoints().string()));
  return std::optional<Checkpoint>(std::in_place, folder.checkpoints() / part, std::move(*keys));
}

double kept_bytes(const Workload& work) {
  // A record and the coverage of a partial face, of which there are few; a label a face; colour and state a texel, and the
  // corrections along seams; previews.
  return 24 * work.pairs + 30 * work.faces + 4.5 * work.texels + held::previews(work);
}

}  // namespace gpvc::pipeline
