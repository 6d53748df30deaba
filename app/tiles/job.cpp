#include "app/tiles/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "app/pipeline/kept_work.h"
#include "app/tiles/done.h"
#include "io/error.h"
#include "io/photos.h"
#include "io/scene_files.h"

namespace gpvc::tiles {
namespace {

namespace fs = std::filesystem;
using Writer = io::WorkStore::Writer;
using Reader = io::WorkStore::Reader;

constexpr const char* kSceneFile = "scene";

void add_text(Writer& out, std::string_view text) { out.add_all(std::span<const char>(text)); }

std::string get_text(Reader& in) {
  const std::vector<char> text = in.get_all<char>();
  return {text.begin(), text.end()};
}

void write_view(Writer& out, const View& view) {
  add_text(out, view.name);
  add_text(out, view.photo.string());
  out.add(view.camera);
  out.add(view.pose);
  add_text(out, view.mask.string());
  out.add(view.uses_alpha);
  out.add(view.reduction);
  out.add(view.number);
}

View read_view(Reader& in) {
  View view;
  view.name = get_text(in);
  view.photo = get_text(in);
  view.camera = in.get<Camera>();
  view.pose = in.get<Pose>();
  view.mask = get_text(in);
  view.uses_alpha = in.get<bool>();
  view.reduction = in.get<int>();
  view.number = in.get<std::uint32_t>();
  return view;
}

void write_model(Writer& out, const io::ModelOptions& model) {
  out.add(model.offset);
  out.add(model.up);
  add_text(out, model.srs);
  out.add(model.srs_offset);
  out.add(model.normals);
  out.add(model.pageless_faces);
}

io::ModelOptions read_model(Reader& in) {
  io::ModelOptions model;
  model.offset = in.get<WorldPoint>();
  model.up = in.get<io::UpAxis>();
  model.srs = get_text(in);
  model.srs_offset = in.get<WorldPoint>();
  model.normals = in.get<bool>();
  model.pageless_faces = in.get<bool>();
  return model;
}

void write_tile(Writer& out, const TileInfo& tile) {
  out.add(tile.box);
  out.add(tile.own_box);
  for (const std::size_t count : {tile.faces, tile.all_faces, tile.vertices}) out.add(count);
  out.add_all(tile.views);
  out.add_all(tile.beside);
  out.add_all(tile.around);
  out.add(tile.color);
  out.add(tile.pairs);
  out.add(tile.texels);
}

TileInfo read_tile_info(Reader& in) {
  TileInfo tile;
  tile.box = in.get<checks::Box>();
  tile.own_box = in.get<checks::Box>();
  for (std::size_t* count : {&tile.faces, &tile.all_faces, &tile.vertices}) *count = in.get<std::size_t>();
  tile.views = in.get_all<ViewId>();
  tile.beside = in.get_all<std::uint32_t>();
  tile.around = in.get_all<std::uint32_t>();
  tile.color = in.get<int>();
  tile.pairs = in.get<double>();
  tile.texels = in.get<double>();
  return tile;
}

}  // namespace

io::WorkKey job_key(const checks::Input& input, const JobSettings& settings, std::string_view program, const Job& job,
                    results::Observer& observer) {
  io::CallbackSource no_photos(input.scene, [](ViewId) { return io::Picture{}; });
  const pipeline::ResultKeys keys = pipeline::result_keys(input, settings.tileset.texture, no_photos, observer);
  io::WorkHash hash;
  hash.add_text(program);
  for (const io::WorkKey& key : {keys.mesh, keys.views, keys.options}) hash.add(key.bits);
  hash.add(settings.tileset.texture.output.quality);
  hash.add(settings.tileset.faces_per_tile);
  hash.add(settings.tileset.compress);
  hash.add(settings.views_per_unit);
  hash.add(settings.levels);
  for (const io::ModelOptions* model : {&job.model, &job.tiles_model}) {
    for (const WorldPoint& p : {model->offset, model->srs_offset})
      for (const double value : {p.x, p.y, p.z}) hash.add(value);
    hash.add(static_cast<int>(model->up));
    hash.add_text(model->srs);
  }
  hash.add_text({reinterpret_cast<const char*>(job.color_profile.data()), job.color_profile.size()});
  for (const ViewId id : input.views) {
    const View& view = input.scene.views[index(id)];
    hash.add_text(view.photo.string());
    hash.add_text(view.mask.string());
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

void JobFolder::write_job(const Job& job, const io::WorkKey& key) const {
  keep(folder_ / "mesh", kSceneFile, key, [&](Writer& out) {
    add_text(out, job.scene.source.string());
    add_text(out, job.scene.srs);
    out.add(job.scene.offset);
    out.add(job.scene.views.size());
    for (const View& view : job.scene.views) write_view(out, view);
    out.add_all(job.views);
    write_model(out, job.model);
    write_model(out, job.tiles_model);
    out.add_all(job.color_profile);
    out.add(job.page_size);
    out.add(job.levels.size());
    for (const Level& level : job.levels) {
      out.add(level.tiles.size());
      for (const TileInfo& tile : level.tiles) write_tile(out, tile);
      out.add(level.reduction);
      out.add(level.texel_size);
    }
    out.add(job.groups.size());
    for (const std::vector<ViewId>& group : job.groups) out.add_all(group);
  });
}

Job JobFolder::read_job() const {
  Job job;
  read_mesh_file(kSceneFile, [&](Reader& in) {
    job.scene.source = get_text(in);
    job.scene.srs = get_text(in);
    job.scene.offset = in.get<WorldPoint>();
    for (auto views = in.get<std::size_t>(); views > 0; --views) job.scene.views.push_back(read_view(in));
    job.views = in.get_all<ViewId>();
    job.model = read_model(in);
    job.tiles_model = read_model(in);
    job.color_profile = in.get_all<std::uint8_t>();
    job.page_size = in.get<int>();
    for (auto levels = in.get<std::size_t>(); levels > 0; --levels) {
      Level& level = job.levels.emplace_back();
      for (auto tiles = in.get<std::size_t>(); tiles > 0; --tiles) level.tiles.push_back(read_tile_info(in));
      level.reduction = in.get<int>();
      level.texel_size = in.get<double>();
    }
    for (auto groups = in.get<std::size_t>(); groups > 0; --groups) job.groups.push_back(in.get_all<ViewId>());
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
  for (const OutputSize& output : done->outputs) {
    std::error_code failed;
    if (fs::file_size(folder_ / output.file, failed) != output.bytes || failed) return std::nullopt;
  }
  return done->key;
}

void JobFolder::remove_units() const {
  for (const char* name : kOfUnits) {
    std::error_code error;
    fs::remove_all(folder_ / name, error);
    if (error) throw OutputError(folder_ / name, "what another job left cannot be removed: " + error.message());
  }
}

void JobFolder::keep(const fs::path& folder, const std::string& name, const io::WorkKey& key,
                     const std::function<void(Writer&)>& write) const {
  io::WorkStore store(folder);
  store.keep(name, key, write);
  if (const std::optional<std::string> failure = store.failure()) throw Error(*failure);
}

void JobFolder::read(const std::string& unit_name, const std::string& name,
                     const std::function<void(Reader&)>& fill) const {
  const std::optional<Done> done = read_done(done_file(unit_name));
  if (!done)
    throw InputError(done_file(unit_name), "", fmt::format("is missing: unit {} has to be done first", unit_name));
  if (!io::WorkStore(unit(unit_name)).read(name, done->key, fill))
    throw InputError(unit(unit_name) / name, "",
                     fmt::format("is missing or damaged; remove {} and run unit {} again",
                                 done_file(unit_name).string(), unit_name));
}

void JobFolder::read_mesh_file(const std::string& name, const std::function<void(Reader&)>& fill) const {
  if (!io::WorkStore(folder_ / "mesh").read(name, key(), fill))
    throw InputError(folder_ / "mesh" / name, "", "is missing or damaged", {Cure::make_job});
}

}  // namespace gpvc::tiles
