#include "app/tiles/local_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "app/pipeline/memory.h"
#include "app/tiles/done.h"
#include "app/tiles/units.h"
#include "io/freed_memory.h"

namespace gpvc::tiles {
namespace {

// Kept for the next run, or gone with this one.
fs::path job_folder(const results::OutputFolder& folder, pipeline::KeepWork keep) {
  return keep == pipeline::KeepWork::never ? folder.in_making() / ".job" : folder.checkpoints() / "job";
}

double most_memory(std::span<const Unit> units) {
  double most = 0;
  for (const Unit& unit : units) most = std::max(most, unit.memory_bytes);
  return most;
}

// Settings with the largest tiles whose units stay below the limit.
JobSettings settings_within(const checks::Input& input, const pipeline::Settings& settings,
                            results::Observer& observer) {
  const auto allowed =
      static_cast<double>(settings.memory_bytes > 0 ? settings.memory_bytes : pipeline::default_memory_limit());
  // The whole mesh stays in memory beside what units take.
  const auto mesh = static_cast<double>(input.mesh.positions.size() * sizeof(WorldPoint) +
                                        input.mesh.faces.size() * sizeof(Triangle));
  const double limit = allowed - mesh;
  constexpr std::size_t kLeastFaces = 1000;
  JobSettings fitting;
  fitting.texture = settings;
  double least = 0;
  bool undivided = false;  // one tile was tried
  for (std::size_t faces = 4000000; faces >= kLeastFaces; faces /= 4) {
    fitting.tiles.faces_per_tile = faces;
    if (faces >= input.mesh.faces.size() && std::exchange(undivided, true)) continue;
    const double needed = most_memory(plan_units(cut_scene(input, fitting, observer)));
    if (needed <= limit) return fitting;
    least = least == 0 ? needed : std::min(least, needed);
  }
  throw pipeline::MemoryError(fmt::format("this run needs about {} of memory even in tiles, and {} may be used",
                                          results::readable_bytes(least + mesh), results::readable_bytes(allowed)),
                              {Cure::more_memory, Cure::smaller_photos, Cure::fewer_faces},
                              {{"needed_bytes", least + mesh}, {"allowed_bytes", allowed}});
}

}  // namespace

void texture_in_tiles(const pipeline::Run& run, const std::string& program, pipeline::OutputFolder& folder) {
  const auto& [input, settings, photos, observer, kept] = run;
  const JobSettings fitting = settings_within(input, settings, observer);
  for (const char* name : {"tileset.json", "index.html"})
    folder.refuse_foreign_file(name);  // now rather than in the end
  const JobFolder job(job_folder(folder, settings.keep_work));
  fs::create_directories(job.path());
  make_job(job, input, fitting, program, observer);
  release_freed_memory();
  UnitRunner runner(job, {settings.memory_bytes, settings.device}, observer);
  for (const Unit& unit : runner.units()) runner.run(unit);
  const fs::path result = job.path() / "result";
  std::vector<std::pair<fs::path, fs::path>> moves;  // the folder takes all names before the job loses a file
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(result))
    if (entry.is_regular_file()) moves.emplace_back(entry.path(), folder.file(fs::relative(entry.path(), result)));
  for (const auto& [from, to] : moves) fs::rename(from, to);
}

void remove_job(const fs::path& out) {
  std::error_code ignored;
  fs::remove_all(out / ".work" / "job", ignored);
  fs::remove(out / ".work", ignored);
}

}  // namespace gpvc::tiles
