// Runs the units of a job.
#pragma once

#include <string>

#include "app/pipeline/pipeline.h"
#include "app/results/observer.h"
#include "app/tiles/job.h"
#include "app/tiles/make_job.h"
#include "app/tiles/plan.h"
#include "app/tileset/tileset_json.h"

namespace gpvc::tiles {

enum class UnitResult { done, was_done };

/// What units share: the job, read once, and its settings.
class UnitRunner {
 public:
  /// Borrows the observer. `settings`: those that make_job() was given, with the memory and the device of this run. Throws
  /// InputError where the folder holds no job.
  UnitRunner(JobFolder folder, const JobSettings& settings, int downscale, results::Observer& observer);

  const std::vector<Unit>& units() const { return units_; }
  /// Throws std::invalid_argument where there is no such unit.
  const Unit& find(const std::string& name) const;

  /// Does nothing where the unit is complete and nothing that it came from has changed. Throws InputError where a unit before it
  /// is not complete, OutputError, and OutputError where another process works on the unit.
  UnitResult run(const Unit& unit);

 private:
  io::WorkKey key_of(const Unit& unit) const;
  void see(const Unit& unit, const io::WorkKey& key);
  void judge(const Unit& unit, const io::WorkKey& key);
  void cost(const Unit& unit, const io::WorkKey& key);
  void choose(const Unit& unit, const io::WorkKey& key);
  void expose(const Unit& unit, const io::WorkKey& key);
  void level(const Unit& unit, const io::WorkKey& key);
  void bake(const Unit& unit);
  void simplify(const Unit& unit, const io::WorkKey& key);
  void ring(const Unit& unit, const io::WorkKey& key);
  void finish();
  int downscale_at(int level) const { return downscale_ * job_.levels[static_cast<std::size_t>(level)].reduction; }
  tileset::Tile tile_of_result(int level, std::size_t number) const;
  void keep(const Unit& unit, const std::string& name, const io::WorkKey& key,
            const std::function<void(io::WorkStore::Writer&)>& write);

  JobFolder folder_;
  pipeline::Settings settings_;
  bool compress_;
  int downscale_;
  results::Observer& observer_;
  Job job_;
  std::vector<Unit> units_;
  struct Outcome;
  Outcome* outcome_ = nullptr;  ///< of the unit that runs
};

}  // namespace gpvc::tiles
