#include "tiny_job.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/cli/setting_options.h"
#include "app/tiles/done.h"
#include "app/tiles/make_job.h"
#include "app/tiles/units.h"

namespace gpvc::fuzz {

namespace fs = std::filesystem;

namespace {

results::Observer nobody;

const Snapshot& tiny_job_files() {
  static const Snapshot kFiles(tiny_job());
  return kFiles;
}

}  // namespace

const fs::path& tiny_job() {
  static const fs::path kJob = [] {
    const fs::path job = folder() / "job";
    tiles::JobSettings settings;
    settings.texture = tiny_settings();
    settings.tiles.faces_per_tile = 100;
    settings.views_per_unit = 2;
    tiles::make_job(tiles::JobFolder(job), tiny().input(), settings, cli::program_version(), nobody);
    std::ofstream(job / "job.json") << nlohmann::ordered_json{
        {"program", cli::program_version()},
        {"settings", cli::settings_json(settings, cli::options_for(pipeline::For::all))}};
    tiles::UnitRunner runner(tiles::JobFolder(job), {}, nobody);
    for (const tiles::Unit& unit : runner.units()) runner.run(unit);
    return job;
  }();
  return kJob;
}

int run_readers(const JobFile& file, const std::function<void(const fs::path&)>& change) {
  tiny_job_files();
  change(tiny_job() / file.file);
  for (const std::string& reader : file.readers) {
    succeeds_or_fails([&] {
      const tiles::JobFolder job(tiny_job());
      tiles::UnitRunner runner(job, {}, nobody);
      fs::remove(job.done_file(reader));
      runner.run(runner.find(reader));
    });
  }
  tiny_job_files().restore();
  return 0;
}

std::vector<std::string> job_seeds(std::span<const JobFile> files, std::string (*body_of)(const fs::path&)) {
  std::vector<std::string> seeds;
  for (std::size_t n = 0; n < files.size(); ++n) seeds.push_back(input_for(n, body_of(tiny_job() / files[n].file)));
  return seeds;
}

void relist(const fs::path& file) {
  const tiles::JobFolder job(tiny_job());
  const bool of_mesh = file.parent_path() == job.path() / "mesh";
  const fs::path list = of_mesh ? job.mesh_files() : file.parent_path() / "done.json";
  std::optional<tiles::Done> done = tiles::read_done(list);
  const tiles::UnitOutput now = tiles::output_of(job.path(), file);
  for (tiles::UnitOutput& output : done.value().outputs)
    if (output.file == now.file) output = now;
  tiles::write_done(list, *done);
}

}  // namespace gpvc::fuzz
