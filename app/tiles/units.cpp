#include "app/tiles/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include "app/results/folder_lock.h"
#include "app/tiles/done.h"
#include "io/clock.h"
#include "io/output_file.h"

namespace gpvc::tiles {

UnitRunner::UnitRunner(JobFolder folder, const UnitLimits& limits, results::Observer& observer)
    : folder_(std::move(folder)),
      observer_(observer),
      job_key_(folder_.key()),
      job_(folder_.read_job()),
      photos_(folder_, job_, job_key_),
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

io::WorkKey UnitRunner::key_of(const Unit& unit) {
  if (folder_.key() != job_key_)
    throw OutputError(folder_.path(), "holds another job than when this run began; run its units again");
  io::WorkHash hash;
  hash.add(job_key_.bits);
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
  if (unit.stage == Stage::judge) {  // whether it ends well depends on them
    hash.add(settings_.allow_misfit);
    hash.add(settings_.allow_unseen);
  }
  photos_.add(unit, hash);
  return hash.key();
}

bool UnitRunner::is_complete(const Unit& unit, const io::WorkKey& key) {
  if (folder_.done(unit.name) != key) return false;
  const std::optional<fs::path> changed = folder_.changed_output(unit.name);
  if (changed)
    observer_.warning(fmt::format("{} is not what unit {} made; the unit is run again", changed->string(), unit.name));
  else
    photos_.keep(unit);
  return !changed;
}

void UnitRunner::note_output(const fs::path& file) { done_->outputs.push_back(output_of(folder_.path(), file)); }

UnitResult UnitRunner::run(const Unit& unit) {
  using Step = void (UnitRunner::*)(const Unit&, const io::WorkKey&);
  // In the order of Stage.
  constexpr Step kSteps[] = {&UnitRunner::see,    &UnitRunner::judge, &UnitRunner::cost, &UnitRunner::choose,
                             &UnitRunner::expose, &UnitRunner::level, &UnitRunner::bake, &UnitRunner::simplify,
                             &UnitRunner::ring,   &UnitRunner::finish};
  static_assert(std::size(kSteps) == std::size(kStageNames));
  const io::WorkKey key = key_of(unit);
  folder_.refuse_links(fs::path("units") / unit.name / "done.json");
  if (is_complete(unit, key)) return UnitResult::was_done;
  const auto most = static_cast<double>(settings_.memory_bytes);
  if (most > 0 && unit.memory_bytes > most && unit.stage != Stage::bake)
    observer_.warning(fmt::format("unit {} may take {} of memory, and only units that bake keep to {}", unit.name,
                                  results::readable_bytes(unit.memory_bytes), results::readable_bytes(most)),
                      {Cure::smaller_tiles, Cure::fewer_unit_views});
  fs::create_directories(folder_.unit(unit.name));
  const results::FolderLock lock(folder_.unit(unit.name));
  // By another process meanwhile.
  if (folder_.done(unit.name) == key && !folder_.changed_output(unit.name)) return UnitResult::was_done;
  std::error_code ignored;
  fs::remove(folder_.done_file(unit.name), ignored);  // what it lists is replaced from here on
  // Without locks another process may be at work.
  if (lock.held()) io::remove_unfinished(folder_.unit(unit.name), "");
  Done done{key};
  done_ = &done;
  const auto start = Clock::now();
  (this->*kSteps[static_cast<std::size_t>(unit.stage)])(unit, key);
  done_ = nullptr;
  if (key_of(unit) != key)
    throw OutputError(folder_.unit(unit.name),
                      "the job or what the unit reads was changed while the unit ran; run it again");
  photos_.keep(unit);
  done.figures["seconds"] = seconds_since(start);
  write_done(folder_.done_file(unit.name), done);
  return UnitResult::done;
}

}  // namespace gpvc::tiles
