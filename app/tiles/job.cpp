#include "app/tiles/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/pipeline/keys.h"
#include "app/results/folder_files.h"
#include "app/tiles/done.h"
#include "app/tiles/job_members.h"
#include "app/tiles/sound.h"
#include "io/error.h"
#include "io/paths.h"
#include "io/photos.h"
#include "io/scene_files.h"

namespace gpvc::tiles {
namespace {

using Writer = io::WorkStore::Writer;
using Reader = io::WorkStore::Reader;

// True if the file is the one that was made.
bool is_as_made(const fs::path& job, const Done& made, const fs::path& file) {
  const auto output = std::ranges::find(made.outputs, file.lexically_relative(job).string(), &UnitOutput::file);
  return output != made.outputs.end() && io::is_file(file) && output_of(job, file) == *output;
}

void drop_folder(const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (error) throw OutputError(folder, "what units have left cannot be removed: " + error.message());
}

}  // namespace

io::WorkKey job_key(const pipeline::Run& run, std::string_view program, const Job& job) {
  io::WorkHash hash;
  hash.add(program);
  hash.add(pipeline::result_keys(run));
  pipeline::add_options(hash, job.settings.texture, pipeline::Affects::models);
  hash.add(job.settings.texture.view_rules);
  hash.add(job.settings.tiles);
  hash.add(job.settings.views_per_unit);
  hash.add(job.settings.levels);
  hash.add(job.model);
  hash.add(job.tiles_model);
  hash.add(job.color_profile);
  hash.add(job.tie_points);
  hash.add(run.input.scene.bands);
  hash.add(run.input.scene.band_places);
  for (const ViewId id : run.input.views) {
    const View& view = run.input.scene.views[index(id)];
    hash.add(view.photo);
    hash.add(view.mask);
    hash.add(view.band_files);
    hash.add(view.band_cameras);
    hash.add(view.uses_alpha);
    hash.add(view.reduction);
  }
  return hash.key();
}

Scene scene_at(const Job& job, int level) {
  Scene scene = job.scene;
  const int reduction = job.levels[static_cast<std::size_t>(level)].reduction;
  for (View& view : scene.views) {
    view.camera = io::reduced_camera(view.camera, reduction);
    view.reduction *= reduction;
  }
  return scene;
}

std::vector<std::uint32_t> tiles_of_group(const Job& job, int level, std::size_t group) {
  const std::vector<TileInfo>& tiles = job.tiles(level);
  std::vector<std::uint32_t> result;
  for (std::uint32_t t = 0; t < tiles.size(); ++t)
    if (std::ranges::any_of(job.groups[group],
                            [&](ViewId view) { return std::ranges::binary_search(tiles[t].views, view); }))
      result.push_back(t);
  return result;
}

JobFolder::JobFolder(fs::path folder)
    : folder_(std::move(folder)), mesh_list_(std::make_shared<DoneList>(mesh_files())) {}

void JobFolder::write_job(const Job& job, const io::WorkKey& key) const {
  keep(folder_ / "mesh", kSceneFile, key, [&](Writer& out) { out.add(job); });
}

Job JobFolder::read_job() const {
  Job job;
  read_mesh_file(kSceneFile, [&](Reader& in) {
    job = in.get<Job>();
    if (!is_sound(job)) in.refuse();
  });
  return job;
}

std::optional<io::WorkKey> JobFolder::key_if_made() const {
  const std::optional<Done> made = read_done(folder_ / "mesh" / "done.json");
  return made ? std::optional(made->key) : std::nullopt;
}

io::WorkKey JobFolder::key() const {
  const std::optional<io::WorkKey> key = key_if_made();
  if (!key) throw InputError(folder_, "", "is no job of units, or one that was not made to its end", {Cure::make_job});
  return *key;
}

std::optional<io::WorkKey> JobFolder::done(const std::string& name) const {
  const std::optional<Done> done = read_done(done_file(name));
  if (!done) return std::nullopt;
  for (const UnitOutput& output : done->outputs) {
    std::error_code failed;
    if (fs::file_size(folder_ / output.file, failed) != output.bytes || failed) return std::nullopt;
  }
  return done->key;
}

std::optional<fs::path> JobFolder::changed_output(const std::string& name) const {
  const std::optional<Done> done = read_done(done_file(name));
  for (const UnitOutput& output : done ? done->outputs : std::vector<UnitOutput>{}) {
    if (output_of(folder_, folder_ / output.file) != output) return folder_ / output.file;
  }
  return std::nullopt;
}

void JobFolder::refuse_links(const fs::path& file) const {
  if (const std::optional<fs::path> link = results::FolderFiles(folder_).link_on_the_way(file))
    throw OutputError(folder_ / *link, "is a symbolic link where a folder of the job is to be; remove it");
}

void JobFolder::remove_units() const {
  for (const char* name : kOfUnits) drop_folder(folder_ / name);
}

void JobFolder::remove_kept() const { drop_folder(folder_ / "units"); }

void JobFolder::keep(const fs::path& folder, const std::string& name, const io::WorkKey& key,
                     const std::function<void(Writer&)>& write) const {
  io::WorkStore store(folder);
  store.keep(name, key, write);
  if (const std::optional<OutputError> failure = store.failure()) throw *failure;
}

void JobFolder::read(const std::string& unit_name, const std::string& name,
                     const std::function<void(Reader&)>& fill) const {
  const std::optional<Done> done = read_done(done_file(unit_name));
  if (!done)
    throw InputError(done_file(unit_name), "", fmt::format("is missing: unit {} has to be done first", unit_name));
  const fs::path file = unit(unit_name) / name;
  if (!is_as_made(folder_, *done, file))
    throw InputError(file, "", fmt::format("is missing or damaged; run unit {} again", unit_name));
  // Then both have been written by somebody else.
  if (!io::WorkStore(file.parent_path()).read(name, done->key, fill))
    throw InputError(file, "",
                     fmt::format("holds values that no unit leaves; remove {} and run unit {} again",
                                 done_file(unit_name).string(), unit_name));
}

void JobFolder::read_mesh_file(const std::string& name, const std::function<void(Reader&)>& fill) const {
  const io::WorkKey made = key();
  const fs::path file = folder_ / "mesh" / name;
  const std::shared_ptr<const Done> files = mesh_list_->read();
  if (!files || files->key != made || !is_as_made(folder_, *files, file) ||
      !io::WorkStore(file.parent_path()).read(name, made, fill))
    throw InputError(file, "", "is missing or damaged", {Cure::make_job});
}

}  // namespace gpvc::tiles
