#include "app/tiles/make_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "app/pipeline/texture_files.h"
#include "app/tiles/done.h"
#include "app/tiles/tile_work.h"
#include "app/tileset/tile_tree.h"
#include "io/output_file.h"

namespace gpvc::tiles {
namespace {

namespace fs = std::filesystem;

TileInfo tile_info(const pipeline::Input& input, const pipeline::Settings& settings, const TileMesh& tile,
                   std::uint32_t number) {
  TileInfo info;
  for (const WorldPoint& p : tile.mesh.positions) info.box.add(p);
  const std::vector<std::uint32_t> own = tile.own(number);
  for (const std::uint32_t f : own)
    for (const std::uint32_t v : tile.mesh.faces[f]) info.written_box.add(tile.mesh.written_positions()[v]);
  info.faces = own.size();
  info.all_faces = tile.face.size();
  info.vertices = tile.vertex.size();
  info.around = tile.tile;
  std::ranges::sort(info.around);
  info.around.erase(std::unique(info.around.begin(), info.around.end()), info.around.end());
  std::erase(info.around, number);
  const auto hull = pipeline::corners(info.box);
  for (const ViewId view : input.views)
    if (pipeline::hull_may_be_framed(input.scene.views[index(view)], hull)) info.views.push_back(view);
  const pipeline::Workload work = pipeline::workload({input.scene, tile.mesh, info.views, input.mesh_file}, settings);
  info.pairs = work.pairs;
  info.texels = work.texels;
  return info;
}

// Cuts the tiles; hands each to `take`.
Job cut(const pipeline::Input& input, const JobSettings& settings, pipeline::Observer& observer,
        const std::function<void(std::uint32_t, const TileMesh&)>& take) {
  observer.begin({"cut", "tiles"});
  const int depth = tileset::tree_depth(input.mesh.faces.size(), settings.tileset.faces_per_tile);
  const std::size_t tiles = std::size_t{1} << (2 * depth);
  const io::UpAxis up = pipeline::scene_up(input.scene, input.views);
  const std::vector<std::uint32_t> leaf = tileset::leaf_of_faces(input.mesh, up, depth);
  TileCutter cutter(input.mesh, leaf, tiles);
  Job job;
  job.views.assign(input.views.begin(), input.views.end());
  for (std::uint32_t t = 0; t < tiles; ++t) {
    observer.progress(t, tiles);
    const TileMesh tile = cutter.cut(t);
    if (take) take(t, tile);
    job.tiles.push_back(tile_info(input, settings.tileset.texture, tile, t));
    job.tiles.back().beside = cutter.beside(t);
  }
  color_tiles(job.tiles);
  job.groups = group_views(input.scene, input.views, settings.views_per_unit);
  // Units run in other folders, and on other machines.
  job.scene.source = input.scene.source;
  job.scene.srs = input.scene.srs;
  job.scene.offset = input.scene.offset;
  job.scene.views = input.scene.views;
  for (View& view : job.scene.views)
    for (fs::path* file : {&view.photo, &view.mask})
      if (!file->empty()) *file = fs::absolute(*file).lexically_normal();
  observer.end(fmt::format("{} tiles, {} groups of views", job.tiles.size(), job.groups.size()));
  return job;
}

}  // namespace

Job cut_scene(const pipeline::Input& input, const JobSettings& settings, pipeline::Observer& observer) {
  return cut(input, settings, observer, {});
}

std::vector<Unit> make_job(const JobFolder& folder, const pipeline::Input& input, const JobSettings& settings,
                           const std::string& program, pipeline::Observer& observer) {
  const pipeline::Settings& texture = settings.tileset.texture;
  const io::WorkKey key = job_key(input, texture, program, settings.tileset.faces_per_tile, observer);
  const fs::path mesh = folder.path() / "mesh";
  Job job = cut(input, settings, observer, [&](std::uint32_t number, const TileMesh& tile) {
    folder.keep(mesh, tile_file(number), key, [&](io::WorkStore::Writer& out) { write(out, tile); });
  });
  // Which faces have a view is not known yet.
  const std::vector<ViewId> any(input.mesh.faces.size(), input.views.front());
  job.model = pipeline::model_options(input, any, texture.output);
  job.model.normals = false;  // they would differ along the borders of tiles
  job.color_profile = pipeline::profile_of_photos(input, observer);
  folder.write_job(job, key);
  std::vector<Unit> units = plan_units(job);
  io::OutputFile plan(folder.path() / "plan.json");
  plan.write(plan_text(units, program));
  plan.commit();
  write_done(mesh / "done.json", {key});
  return units;
}

}  // namespace gpvc::tiles
