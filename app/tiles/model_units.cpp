// The units that make what users see: textured tiles, their levels of detail, and the tileset.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "app/pipeline/bake_into.h"
#include "app/pipeline/memory.h"
#include "app/pipeline/stored.h"
#include "app/pipeline/texture_files.h"
#include "app/tiles/done.h"
#include "app/tiles/tile_atlas.h"
#include "app/tiles/tile_work.h"
#include "app/tiles/units.h"
#include "app/tileset/tile_files.h"
#include "app/tileset/tileset_json.h"
#include "io/output_file.h"
#include "io/paths.h"

namespace gpvc::tiles {
namespace {

// \param reduction of the photos that they are for
std::vector<atlas::ViewExposure> load_exposure(const JobFolder& folder, const Job& job, double reduction) {
  auto exposure = folder.get<std::vector<atlas::ViewExposure>>(kLevelUnit, "exposure", [&](const auto& found) {
    return (found.empty() || found.size() == job.scene.views.size()) &&
           std::ranges::all_of(found, [](const atlas::ViewExposure& each) { return atlas::is_sound(each); });
  });
  for (atlas::ViewExposure& each : exposure) {
    each.centre_x /= reduction;
    each.centre_y /= reduction;
    each.inverse_radius2 *= reduction * reduction;
  }
  return exposure;
}

// \param reduction of the photos that they are for
std::vector<ShiftField> load_alignment(const JobFolder& folder, const Job& job, double reduction) {
  auto fields = folder.get<std::vector<ShiftField>>(kLevelUnit, "alignment", [&](const auto& found) {
    return (found.empty() || found.size() == job.scene.views.size()) &&
           std::ranges::all_of(found, [](const ShiftField& field) { return atlas::is_sound(field); });
  });
  fields.resize(job.scene.views.size());  // a tile fits none of its own
  return atlas::reduced(std::move(fields), reduction);
}

fs::path glb_of(const JobFolder& folder, int level, std::size_t tile) {
  return folder.path() / "result" / "tiles" / fmt::format("{}_{}.glb", level, tile);
}

// Takes holes that reach beyond the tile's faces into what is baked, with the faces around them: a hole is filled from all
// around, and both tiles that share it must come to the same colours where they meet.
void take_in_holes(TileAtlas& atlas) {
  // A hole that goes on farther is cut there, where its colours hardly depend on what lies beyond.
  constexpr int kHoleEdges = 24;
  const auto neighbours = group_neighbours(atlas.labels.size(), atlas.graph.edges);
  const auto unseen = [&](std::uint32_t f) { return !labeling::has_candidates(atlas.costs.tags[f]); };
  std::vector<std::uint32_t> hole;
  for (std::uint32_t f = 0; f < atlas.labels.size(); ++f)
    if (atlas.border[f] == 0 && unseen(f)) hole.push_back(f);
  for (std::size_t begin = 0, ring = 0; ring < kHoleEdges && begin < hole.size(); ++ring)
    for (const std::size_t end = hole.size(); begin < end; ++begin)
      for (const std::uint32_t next : std::as_const(neighbours)[hole[begin]])
        if (unseen(next) && std::exchange(atlas.border[next], std::uint8_t{0}) != 0) hole.push_back(next);
  for (const std::uint32_t f : hole)
    for (const std::uint32_t next : std::as_const(neighbours)[f])
      if (!unseen(next)) atlas.border[next] = 0;
}

}  // namespace

void UnitRunner::bake(const Unit& unit, const io::WorkKey& /*key*/) {
  TileAtlas tile(folder_, job_, unit.level, unit.number);
  take_in_holes(tile);
  const std::vector<std::uint32_t> own = tile.tile.own(unit.number);
  if (own.empty()) return;
  const Level& level = job_.levels[static_cast<std::size_t>(unit.level)];
  const std::vector<atlas::ViewExposure> exposure = load_exposure(folder_, job_, level.reduction);
  const std::vector<ShiftField> alignment = load_alignment(folder_, job_, level.reduction);
  const std::vector<ViewId>& views = level.tiles[unit.number].views;
  const Scene scene = scene_at(job_, unit.level);
  const pipeline::Input input{scene, tile.tile.mesh, views, job_.mesh_file};
  pipeline::Settings settings = settings_;
  settings.atlas.texel_size = level.texel_size;
  const pipeline::MemoryPlan memory = pipeline::plan_baking(input, settings, tile.costs.coverage, unit.memory_bytes);
  io::PhotoCache decoded(scene, 0, &photos_.hashes());
  io::CoarsePhotos photos =
      pipeline::with_coarse_photos({input, settings, decoded, observer_}, memory.work, 0, folder_.unit(unit.name));
  // Levels above have no model.obj; their pages are in the GLB alone.
  const bool finest = unit.level == 0;
  const fs::path glb = glb_of(folder_, unit.level, unit.number);
  const fs::path obj =
      finest ? folder_.path() / "result" / "obj" / fmt::to_string(unit.number) : folder_.unit(unit.name);
  for (const fs::path& file : {glb, obj / "model.obj"}) {
    folder_.refuse_links(file.lexically_relative(folder_.path()));
    fs::create_directories(file.parent_path());
  }
  io::remove_unfinished(obj, "");
  io::remove_unfinished(glb.parent_path(), glb.filename().string());
  tileset::PageFiles pages(obj, "", settings.output, job_.color_profile, finest);
  const atlas::TextureAtlas atlas =
      pipeline::bake_into({input, settings, photos, observer_}, tile.input(scene, photos, exposure, alignment), memory,
                          {.stage = unit.name, .scratch_folder = folder_.unit(unit.name)}, &pages);
  tileset::TileModel model = tileset::tile_model(atlas.model, own, pages.files(), [&](std::uint32_t f) {
    return atlas::is_dropped(settings.atlas.unseen, tile.costs.tags[f]);
  });
  tileset::add_photos(model, scene, own, tile.labels);
  if (finest) {
    model.model.mesh = &model.mesh;
    io::write_obj(obj / "model.obj", model.model, model.pages, job_.model);
    if (pipeline::has_offset(job_.model)) pipeline::write_offset(job_.model, obj / pipeline::kOffsetFile);
    if (!job_.model.srs.empty()) pipeline::write_metadata(job_.model, obj / pipeline::kMetadataFile);
  }
  tileset::write_tile(glb, model, job_.tiles_model, settings.output, folder_.unit(unit.name));
  note_output(glb);
  if (finest) {
    for (const io::PageFile& page : pages.files()) {
      note_output(page.file);
      if (scene.bands) note_output(pipeline::samples_of(page.file, settings.output.band_format));
    }
    for (const char* name : {"model.obj", "model.mtl", pipeline::kOffsetFile, pipeline::kMetadataFile})
      if (io::is_file(obj / name)) note_output(obj / name);
  } else {
    pages.remove();
  }
  auto& figures = done_->figures;
  figures["charts"] = atlas.statistics.charts;
  figures["page_texels"] = atlas.statistics.page_texels;
  figures["seam_edges"] = atlas.statistics.seam_edges;
  figures["seam_step_before"] = atlas.statistics.seam_step_before;
  figures["seam_step_after"] = atlas.statistics.seam_step_after;
}

namespace {

// What viewers take an empty tile for: all of it is missing.
double diagonal_of(const std::vector<TileInfo>& tiles) {
  checks::Box all;
  for (const TileInfo& tile : tiles)
    for (const WorldPoint& corner : checks::corners(tile.own_box))
      if (tile.faces > 0) all.add(corner);
  return std::hypot(all.high.x - all.low.x, all.high.y - all.low.y, all.high.z - all.low.z);
}

}  // namespace

void UnitRunner::simplify(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  TileUnion children;
  double error = 0;
  for (std::uint32_t child = 4 * unit.number; child < 4 * unit.number + 4; ++child) {
    const CoarseTile tile = load_own(folder_, job_, unit.level - 1, child);
    children.add(tile.tile, child);
    error = std::max(error, tile.error);
  }
  children.finish();
  CoarseTile coarse = coarse_tile(children, unit.number);
  coarse.error += error;
  put(unit, "tile", key, coarse);
  done_->figures["faces"] = coarse.tile.face.size();
  done_->figures["error"] = coarse.error;
  observer_.end(fmt::format("{} faces", results::readable_count(coarse.tile.face.size())));
}

void UnitRunner::ring(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  TileUnion all;
  all.add(load_own(folder_, job_, unit.level, unit.number).tile, unit.number);
  for (const std::uint32_t other : job_.tiles(unit.level)[unit.number].around)
    all.add(load_own(folder_, job_, unit.level, other).tile, other);
  all.finish();
  const TileMesh tile = with_border(all, unit.number);
  put(unit, "tile", key, tile);
  observer_.end(fmt::format("{} faces with the border", results::readable_count(tile.face.size())));
}

tileset::Tile UnitRunner::tile_of_result(int level, std::size_t number) const {
  tileset::Tile tile;
  const fs::path glb = glb_of(folder_, level, number);
  if (!io::is_file(glb)) return tile;  // it has no faces
  tile.file = fs::relative(glb, folder_.path() / "result").string();
  for (const WorldPoint& corner : checks::corners(job_.tiles(level)[number].own_box))
    tile.box.add(tileset::tile_from_world(job_.tiles_model, corner));
  if (level == 0) return tile;
  const double texel = job_.levels[static_cast<std::size_t>(level)].texel_size;
  tile.error =
      tileset::geometric_error(load_own(folder_, job_, level, static_cast<std::uint32_t>(number)).error, texel);
  return tile;
}

void UnitRunner::finish(const Unit& /*unit*/, const io::WorkKey& /*key*/) {
  observer_.begin({kFinishUnit});
  const double diagonal = diagonal_of(job_.tiles(0));
  std::vector<std::vector<tileset::Tile>> levels;
  for (int k = 0; k < static_cast<int>(job_.levels.size()); ++k) {
    std::vector<tileset::Tile>& tiles = levels.emplace_back();
    for (std::size_t t = 0; t < job_.tiles(k).size(); ++t) tiles.push_back(tile_of_result(k, t));
  }
  // Without levels of detail, tiles above the leaves have nothing to show, so that viewers go on to the leaves from anywhere.
  while (levels.back().size() > 1) levels.emplace_back(levels.back().size() / 4, tileset::Tile{{}, {}, diagonal});
  const fs::path result = folder_.path() / "result";
  for (const char* name : {"tileset.json", "index.html"}) {
    folder_.refuse_links(fs::path("result") / name);
    fs::create_directories(result);
    io::remove_unfinished(result, name);
  }
  const std::optional<tileset::Place>& place = job_.settings.tiles.place;
  tileset::write_tileset(result, levels, job_.tiles_model, place);
  for (const char* name : {"tileset.json", "index.html"}) note_output(result / name);
  if (const std::string remark = tileset::remark_on_placing(job_.tiles_model, place); !remark.empty())
    observer_.note(remark);
  auto& figures = done_->figures;
  std::map<std::string, double> sums;
  double steps_before = 0, steps_after = 0;
  for (const Unit& unit : units_) {
    const std::optional<Done> done = unit.level == 0 ? read_done(folder_.done_file(unit.name)) : std::nullopt;
    if (!done) continue;
    const auto figure = [&](const char* name) {
      return done->figures.contains(name) && done->figures[name].is_number() ? done->figures[name].get<double>() : 0;
    };
    for (const char* name : {"full", "partial", "seen", "filled", "background", "energy", "pairs", "seams",
                             "pairs_across", "seams_across", "charts", "page_texels", "seam_edges"})
      if (done->figures.contains(name))
        sums[std::string(name_of(kStageNames, unit.stage)) + "." + name] += figure(name);
    steps_before += figure("seam_edges") * figure("seam_step_before");
    steps_after += figure("seam_edges") * figure("seam_step_after");
  }
  for (const auto& [name, value] : sums) {
    figures[name] = value;
    observer_.figure(name, value);
  }
  const double edges = std::max(1.0, sums["bake.seam_edges"]);
  figures["seam_step_before"] = steps_before / edges;
  figures["seam_step_after"] = steps_after / edges;
  observer_.end(fmt::format("energy {:.0f}, seam step {:.1f} to {:.1f}", sums["expose.energy"], steps_before / edges,
                            steps_after / edges));
}

}  // namespace gpvc::tiles
