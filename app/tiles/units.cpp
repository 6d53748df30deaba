#include "app/tiles/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

#include "app/results/folder_lock.h"
#include "app/tiles/unit_outcome.h"
#include "io/clock.h"

namespace gpvc::tiles {
namespace fs = std::filesystem;

UnitRunner::UnitRunner(JobFolder folder, const UnitLimits& limits, results::Observer& observer)
    : folder_(std::move(folder)),
      observer_(observer),
      job_(folder_.read_job()),
      settings_(job_.settings.texture),
      units_(plan_units(job_)) {
  settings_.memory_bytes = limits.memory_bytes;
  settings_.device = limits.device;
}

const Unit& UnitRunner::find(const std::string& name) const {
  const auto found = std::ranges::find(units_, name, &Unit::name);
  if (found == units_.end()) throw std::invalid_argument(fmt::format("the job has no unit '{}'", name));
  return *found;
}

io::WorkKey UnitRunner::key_of(const Unit& unit) const {
  io::WorkHash hash;
  hash.add(folder_.key().bits);
  hash.add(unit.name);
  std::vector<std::string> missing;
  for (const std::string& before : unit.after) {
    const std::optional<io::WorkKey> key = folder_.done(before);
    if (!key) missing.push_back(before);
    hash.add(key.value_or(io::WorkKey{}).bits);
  }
  if (!missing.empty())
    throw InputError(folder_.path(), "unit " + unit.name,
                     fmt::format("{} must be complete before: {}", missing.size() == 1 ? "a unit" : "units",
                                 results::readable_list(missing, 5)));
  if (unit.stage == Stage::see)
    for (const ViewId id : job_.groups[unit.number]) {
      hash.add(id);  // jobs of one input may have other groups
      for (const fs::path& file : {job_.scene.views[index(id)].photo, job_.scene.views[index(id)].mask}) {
        if (file.empty()) continue;
        std::error_code failed;
        hash.add(fs::file_size(file, failed));
        hash.add(fs::last_write_time(file, failed).time_since_epoch().count());
      }
    }
  return hash.key();
}

void UnitRunner::note_output(const fs::path& file) {
  outcome_->done.outputs.push_back({fs::relative(file, folder_.path()).string(), fs::file_size(file)});
}

UnitResult UnitRunner::run(const Unit& unit) {
  const io::WorkKey key = key_of(unit);
  if (folder_.done(unit.name) == key) return UnitResult::was_done;
  const auto most = static_cast<double>(settings_.memory_bytes);
  if (most > 0 && unit.memory_bytes > most && unit.stage != Stage::bake)
    observer_.warning(fmt::format("unit {} may take {} of memory, and only units that bake keep to {}", unit.name,
                                  results::readable_bytes(unit.memory_bytes), results::readable_bytes(most)),
                      {Cure::smaller_tiles, Cure::fewer_unit_views});
  fs::create_directories(folder_.unit(unit.name));
  const results::FolderLock lock(folder_.unit(unit.name));
  if (folder_.done(unit.name) == key) return UnitResult::was_done;  // by another process meanwhile
  std::error_code ignored;
  fs::remove(folder_.done_file(unit.name), ignored);  // what it lists is replaced from here on
  Outcome outcome{{key}};
  outcome_ = &outcome;
  const auto start = Clock::now();
  switch (unit.stage) {
    case Stage::see:
      see(unit, key);
      break;
    case Stage::judge:
      judge(unit, key);
      break;
    case Stage::cost:
      cost(unit, key);
      break;
    case Stage::choose:
      choose(unit, key);
      break;
    case Stage::expose:
      expose(unit, key);
      break;
    case Stage::level:
      level(unit, key);
      break;
    case Stage::bake:
      bake(unit);
      break;
    case Stage::simplify:
      simplify(unit, key);
      break;
    case Stage::ring:
      ring(unit, key);
      break;
    case Stage::finish:
      finish();
      break;
  }
  outcome_ = nullptr;
  if (key_of(unit) != key)
    throw OutputError(folder_.unit(unit.name),
                      "the job or what the unit reads was changed while the unit ran; run it again");
  outcome.done.figures["seconds"] = seconds_since(start);
  write_done(folder_.done_file(unit.name), outcome.done);
  return UnitResult::done;
}

}  // namespace gpvc::tiles
