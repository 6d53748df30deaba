// Runs the units of a job.
#pragma once

#include <string>

#include "app/pipeline/pipeline.h"
#include "app/results/observer.h"
#include "app/tiles/job.h"
#include "app/tiles/job_members.h"
#include "app/tiles/job_photos.h"
#include "app/tiles/plan.h"
#include "app/tileset/tileset_json.h"

namespace gpvc::tiles {

struct Done;
enum class UnitResult { done, was_done };

/// What this machine gives to units.
struct UnitLimits {
  std::size_t memory_bytes = 0;  ///< as pipeline::Settings
  int device = -1;
};

/// What units share: the job, read once, with its settings.
class UnitRunner {
 public:
  /// Borrows the observer. Throws InputError where the folder holds no job.
  UnitRunner(JobFolder folder, const UnitLimits& limits, results::Observer& observer);
  UnitRunner(const UnitRunner&) = delete;
  UnitRunner& operator=(const UnitRunner&) = delete;

  const Job& job() const { return job_; }
  const std::vector<Unit>& units() const { return units_; }
  /// Throws std::invalid_argument where there is no such unit.
  const Unit& find(const std::string& name) const;

  /// Does nothing where the unit is complete, its files are what it made, and nothing that it came from has changed. Throws
  /// InputError where a unit before it is not complete, or a photo is not the one that was looked at; OutputError, also
  /// where another process works on the unit, or the job has been replaced since it was read.
  UnitResult run(const Unit& unit);

 private:
  io::WorkKey key_of(const Unit& unit);
  bool is_complete(const Unit& unit, const io::WorkKey& key);
  void see(const Unit& unit, const io::WorkKey& key);
  void judge(const Unit& unit, const io::WorkKey& key);
  void cost(const Unit& unit, const io::WorkKey& key);
  void choose(const Unit& unit, const io::WorkKey& key);
  void expose(const Unit& unit, const io::WorkKey& key);
  void level(const Unit& unit, const io::WorkKey& key);
  void bake(const Unit& unit, const io::WorkKey& key);
  void simplify(const Unit& unit, const io::WorkKey& key);
  void ring(const Unit& unit, const io::WorkKey& key);
  void finish(const Unit& unit, const io::WorkKey& key);
  tileset::Tile tile_of_result(int level, std::size_t number) const;
  /// Leaves a part of what a unit makes.
  template <typename Part>
  void put(const Unit& unit, const std::string& name, const io::WorkKey& key, const Part& part) {
    folder_.keep(folder_.unit(unit.name), name, key, [&](io::WorkStore::Writer& out) { out.add(part); });
    note_output(folder_.unit(unit.name) / name);
  }
  void note_output(const std::filesystem::path& file);

  JobFolder folder_;
  results::Observer& observer_;
  io::WorkKey job_key_;  ///< read before the job, so that the two differ if it is replaced in between
  Job job_;
  JobPhotos photos_;
  pipeline::Settings settings_;  ///< the job's, within the limits
  std::vector<Unit> units_;
  Done* done_ = nullptr;  ///< of the unit that runs: what it notes
};

}  // namespace gpvc::tiles
