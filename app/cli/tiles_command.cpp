// gpvc tiles, unit and plan: jobs of units.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "app/cli/interrupt.h"
#include "app/cli/large_blocks.h"
#include "app/cli/scene_input.h"
#include "app/cli/setting_options.h"
#include "app/pipeline/memory.h"
#include "app/results/folder_lock.h"
#include "app/tiles/plan_text.h"
#include "app/tiles/units.h"
#include "io/file_bytes.h"
#include "io/mesh.h"
#include "io/paths.h"

namespace gpvc::cli {
namespace {

namespace fs = std::filesystem;

// What job.json lists of a job. Throws InputError where the job was made by another version of the program.
Json read_listing(const fs::path& job) {
  const fs::path file = job / "job.json";
  if (!io::is_file(file)) throw InputError(job, "", "is no job: gpvc tiles makes one, with job.json in it");
  const io::FileBytes bytes(file);
  const Json json = Json::parse(bytes.view(), nullptr, false);
  if (!json.is_object() || !json.contains("program") || !json["program"].is_string())
    throw InputError(file, "", "expected an object with \"program\" and \"settings\", as gpvc tiles writes it");
  const auto made_by = json["program"].get<std::string>();
  if (made_by != program_version())
    throw InputError(
        file, "",
        fmt::format("was made by gpvc {}, and this is gpvc {}: what two versions make does not fit together; "
                    "make the job again, or go on with that one",
                    made_by, program_version()));
  return json;
}

// Units work with the options that mesh/scene holds; job.json only shows them to people. Throws InputError where the two differ,
// since a user who edited job.json expects the edited options to be used.
void check_listing(const fs::path& job, const tiles::JobSettings& settings) {
  const Json json = read_listing(job);
  const Json listed = json.contains("settings") ? json["settings"] : Json();
  const Json made = Json::parse(evaluate::json_text(settings_json(settings, options_for(pipeline::For::all))));
  std::vector<std::string> other;
  for (const auto& [name, value] : made.items())
    if (!listed.is_object() || !listed.contains(name) || listed[name] != value) other.push_back(name);
  if (!other.empty())
    throw InputError(job / "job.json", "settings",
                     fmt::format("expected what the job was made with, which differs in {}; it cannot be edited",
                                 results::readable_list(other, 5)),
                     {Cure::make_job});
}

// Keeps a mesh that may be too large for the memory on disk while it is read and cut.
void make_room(const TilesOptions& options, const fs::path& scratch, Console& console) {
  double bytes = 0;
  std::vector<fs::path> meshes{options.input.mesh};
  meshes.insert(meshes.end(), options.input.more_meshes.begin(), options.input.more_meshes.end());
  for (const fs::path& mesh : meshes)
    for (const fs::path& file : io::mesh_files(mesh)) {
      std::error_code unknown;
      const std::uintmax_t size = fs::file_size(file, unknown);
      if (!unknown) bytes += static_cast<double>(size);
    }
  // A binary PLY has some 19 bytes a face, positions, faces and what is needed to cut them 110; a text has more of the former.
  constexpr double kMemoryOfFile = 6;
  const std::size_t given = options.settings.texture.memory_bytes;
  const auto most = static_cast<double>(given > 0 ? given : pipeline::default_memory_limit());
  if (kMemoryOfFile * bytes < most) return;
  keep_large_blocks_in(scratch);
  console.note(fmt::format("the mesh is kept on disk while it is cut, as it may take {} of memory",
                           results::readable_bytes(kMemoryOfFile * bytes)));
}

// Shows the stages of units on the console.
void run_units(tiles::UnitRunner& runner, std::span<const tiles::Unit* const> units, Console& console) {
  std::size_t were_done = 0;
  for (const tiles::Unit* unit : units) {
    throw_if_interrupted();
    if (runner.run(*unit) == tiles::UnitResult::was_done) {
      ++were_done;
      if (units.size() == 1) console.note(fmt::format("unit {} is complete", unit->name));
    }
  }
  if (were_done > 0 && units.size() > 1)
    console.note(fmt::format("{} of {} units were complete", were_done, units.size()));
}

// Throws OutputError where files lie in the folders that a job's units write, but no job does, and where a file that the
// run reads is among them.
void protect_unit_folders(const TilesOptions& options, bool has_job, const std::set<fs::path>& inputs) {
  for (const char* name : tiles::JobFolder::kOfUnits) {
    const fs::path folder = options.out / name;
    std::error_code ignored;
    if (!has_job && fs::exists(fs::symlink_status(folder, ignored)))
      throw OutputError(folder, "exists and is not of a job of gpvc tiles; choose another output folder");
    const fs::path within = fs::weakly_canonical(folder) / "";
    for (const fs::path& input : inputs)
      if (input.string().starts_with(within.string()))
        throw OutputError(input, fmt::format("is read by this run, which would remove {}; choose another output folder",
                                             folder.string()));
  }
}

}  // namespace

void run_tiles(const TilesOptions& options, Console& console) {
  check_places(options.input);
  refuse_contradictions(options.settings.texture);
  refuse_overwriting(options.input, options.out, {"job.json", "plan.json"});
  const bool has_job = io::is_file(options.out / "job.json");
  run_command("tiles", options, console, [&](RunRecord& record, results::OutputFolder& folder) -> RunFacts {
    const std::optional<io::WorkKey> before = tiles::JobFolder(options.out).key_if_made();
    protect_unit_folders(options, has_job, {});
    make_room(options, folder.in_making(), console);
    const SceneInputData in = read_scene_input(options.input, record);
    std::set<fs::path> read = input_files(in);
    tiles::JobSettings settings = options.settings;
    settings.texture.view_rules = rules_of(options.allow, in, read);
    folder.protect(read);
    protect_unit_folders(options, has_job, read);
    const std::vector<tiles::Unit> units =
        tiles::make_job(tiles::JobFolder(folder.in_making()), in.input(), settings, program_version(), record);
    Json made = settings_json(settings, options_for(pipeline::For::all));
    made["allow"] = options.allow.string();
    evaluate::write_json(folder.file("job.json"),
                         {{"program", program_version()}, {"scene", scene_json(options.input)}, {"settings", made}});
    folder.promise_all();
    evaluate::write_views_json(folder.file("views.json"), in.scene, in.used, in.held_out);
    for (const std::string& line : tiles::plan_table(units)) record.note(line);
    // What units of another job have left would lie among the tiles of this one. It goes before this one comes: schedulers
    // that look for done.json alone must never find the one with the other's.
    if (before != tiles::JobFolder(folder.in_making()).key_if_made()) tiles::JobFolder(options.out).remove_units();
    return {scene_json(options.input), Json::object(), (options.out / "plan.json").string()};
  });
}

void run_unit(const UnitOptions& options, Console& console) {
  if (options.names.empty() != options.all) throw UsageError("gpvc unit takes the names of units, or --all");
  if (options.clean && !options.all) throw UsageError("--clean belongs to --all");
  console.speak_of_job();
  results::OutputFolder::finish_interrupted(options.job);
  read_listing(options.job);
  RunRecord record(console);
  std::optional<results::FolderLock> driver;
  if (options.all) driver.emplace(options.job);
  console.note_kept(options.job / "units", "units that are complete are kept");
  tiles::UnitRunner runner(tiles::JobFolder(options.job), {options.limits.memory_bytes, options.common.device}, record);
  const EndsSoonAfterSignal ends([&] { console.interrupted(); });  // units survive kills
  check_listing(options.job, runner.job().settings);
  std::vector<const tiles::Unit*> units;
  for (const std::string& name : options.names) try {
      units.push_back(&runner.find(name));
    } catch (const std::invalid_argument& error) {
      throw UsageError(fmt::format("{}: {}; plan.json lists them", options.job.string(), error.what()));
    }
  if (options.all)
    for (const tiles::Unit& unit : runner.units()) units.push_back(&unit);
  run_units(runner, units, console);
  if (options.clean) tiles::JobFolder(options.job).remove_kept();
  if (std::ranges::any_of(units, [](const tiles::Unit* unit) { return unit->stage == tiles::Stage::finish; }))
    console.result((options.job / "result" / "tileset.json").string());
}

void run_plan(const PlanOptions& options, Console& console) {
  results::OutputFolder::finish_interrupted(options.job);
  read_listing(options.job);
  const tiles::Job job = tiles::JobFolder(options.job).read_job();
  check_listing(options.job, job.settings);
  const std::vector<tiles::Unit> units = tiles::plan_units(job);
  if (options.sbatch) {
    console.result(
        tiles::sbatch_text(units, fs::absolute(options.job).lexically_normal(), fs::read_symlink("/proc/self/exe")));
    return;
  }
  for (const std::string& line : tiles::plan_table(units)) console.result(line);
}

}  // namespace gpvc::cli
