// gpvc texture and gpvc tileset: each reads its input, runs the library, writes the result.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

#include "app/cli/scene_input.h"
#include "app/pipeline/memory.h"
#include "app/tiles/local_run.h"

namespace gpvc::cli {
namespace {

// The settings that all textured results have.
Json settings_json(const pipeline::Settings& s) {
  Json json = visibility_json(s.visibility);
  json["data_term"] = name_of(labeling::kDataTermNames, s.costs.term);
  json["outliers"] = name_of(labeling::kOutliersNames, s.costs.outliers);
  json["keep_views"] = s.costs.keep_views;
  json["allow_unseen"] = s.allow_unseen;
  json["margin_px"] = s.costs.margin_px;
  json["smoothness"] = s.solver.smoothness;
  json["edge_weights"] = name_of(labeling::kEdgeWeightsNames, s.edge_weights);
  json["max_sweeps"] = s.solver.max_sweeps;
  json["thorough"] = s.solver.thorough;
  json["page_size"] = s.atlas.page_size;
  json["padding"] = s.atlas.padding;
  json["texel_size"] = s.atlas.texel_size;
  json["unseen"] = name_of(atlas::kUnseenFacesNames, s.atlas.unseen);
  json["unseen_color"] = s.atlas.unseen_color;
  json["seams"] = name_of(atlas::kSeamLevelingNames, s.atlas.seams);
  json["blend"] = name_of(atlas::kBlendingNames, s.atlas.blend);
  json["texture"] = name_of(io::kImageFormatNames, s.output.texture);
  json["quality"] = s.output.quality;
  json["memory"] = s.memory_bytes;
  json["up"] = s.output.up ? "given" : "auto";
  return json;
}

Json options_json(const TextureOptions& o) {
  const pipeline::Settings& s = o.settings;
  Json json = scene_json(o.input);
  json.update(settings_json(s));
  json["allow"] = o.allow.string();
  json["from"] = o.from.string();
  json["editable"] = s.editable || !o.from.empty();
  json["gltf"] = name_of(io::kGltfContainerNames, s.output.gltf);
  json["normals"] = s.output.normals;
  json["max_pages"] = s.atlas.max_pages;
  json["max_texels"] = s.atlas.max_texels;
  json["resume"] = name_of(pipeline::kKeepWorkNames, s.keep_work);
  return json;
}

Json options_json(const TilesetOptions& o) {
  Json json = scene_json(o.input);
  json.update(settings_json(o.settings.texture));
  json["tile_faces"] = o.settings.faces_per_tile;
  json["compress"] = o.settings.compress;
  return json;
}

Json levels_json(const tileset::TilesetReport& report) {
  Json levels = Json::array();
  for (const tileset::LevelReport& level : report.levels)
    levels.push_back({{"tiles", level.tiles},
                      {"faces", level.faces},
                      {"page_texels", level.page_texels},
                      {"bytes", level.bytes},
                      {"texel_size", level.texel_size},
                      {"geometric_error", level.error}});
  return levels;
}

// The camera and background of preview.png, so that pictures of other renderers can be compared with it.
Json preview_json(const pipeline::WrittenModel& written) {
  Json json = evaluate::camera_json(written.preview.camera, written.preview.pose);
  json.erase("distortion");  // it has none
  json["background"] = written.background;
  return json;
}

// What has no meaning for a result in tiles.
bool needs_one_model(const TextureOptions& o) {
  const pipeline::Settings& s = o.settings;
  return !s.view_rules.empty() || !o.allow.empty() || s.editable || !o.from.empty() || s.atlas.max_pages > 0 ||
         s.atlas.max_texels > 0;
}

// What was asked for and tiles do not have: the end of a sentence.
std::string without_in_tiles(const TextureOptions& o) {
  const bool files = o.settings.output.gltf != io::GltfContainer::glb;
  if (!o.settings.output.normals && !files) return "";
  return fmt::format(", without {}{}{}", o.settings.output.normals ? "normals" : "",
                     o.settings.output.normals && files ? " and " : "", files ? "model.gltf" : "");
}

}  // namespace

void run_texture(const TextureOptions& options, Console& console) {
  refuse_overwriting(options.input, options.out, {"model.obj"});
  if (options.settings.keep_work != pipeline::KeepWork::never)
    console.note_kept(options.out / ".work", fmt::format("work is kept in {}, and the same command goes on from there",
                                                         (options.out / ".work").string()));
  run_command("texture", options, console, [&](RunRecord& record, results::OutputFolder& folder) -> RunFacts {
    const SceneInputData in = read_scene_input(options.input, record);
    check_photos(in);
    std::set<std::filesystem::path> read = input_files(in);
    pipeline::Settings settings = options.settings;
    if (!options.allow.empty()) {
      settings.view_rules = read_rules(options.allow, in.scene.views, in.mesh.faces.size());
      read.insert(options.allow);
    }
    folder.protect(read);
    io::PhotoCache photos(in.scene, options.input.downscale);
    settings.device = options.common.device;
    evaluate::write_views_json(folder.file("views.json"), in.scene, in.used, in.held_out);
    std::optional<pipeline::TexturedFiles> files;
    try {
      files = options.from.empty()
                  ? pipeline::texture_into(in.input(), settings, photos, folder, record)
                  : pipeline::retexture_into(options.from, in.input(), settings, photos, folder, record);
    } catch (const pipeline::MemoryError& too_little) {
      if (needs_one_model(options)) throw;
      record.warning(fmt::format("{}. It goes on in tiles, one after another: the result is tileset.json{}",
                                 too_little.what(), without_in_tiles(options)));
      folder.start_over();
      evaluate::write_views_json(folder.file("views.json"), in.scene, in.used, in.held_out);
      tiles::texture_in_tiles(in.input(), settings, options.input.downscale, program_version(), folder, record);
      TextureOptions done = options;
      done.settings.output.normals = false;
      done.settings.output.gltf = io::GltfContainer::glb;
      return {options_json(done), Json::object(), (options.out / "tileset.json").string()};
    }
    const auto& [textured, written] = *files;
    record.counts["preview"] = preview_json(written);
    record.counts["up"] = name_of(io::kUpAxisNames, written.up);
    record.counts["offset"] = evaluate::point_json(written.offset);
    std::string models;
    for (const char* name : {"model.obj", "model.glb", "model.gltf", "preview.png"})
      if (std::ranges::count(folder.promised(), name) > 0)
        models += (models.empty() ? "" : "\n") + (options.out / name).string();
    return {options_json(options), evaluate::device_json(textured.device), models};
  });
  tiles::remove_job(options.out);
}

void run_tileset(const TilesetOptions& options, Console& console) {
  refuse_overwriting(options.input, options.out, {"tileset.json"});
  run_command("tileset", options, console, [&](RunRecord& record, results::OutputFolder& folder) -> RunFacts {
    const SceneInputData in = read_scene_input(options.input, record);
    check_photos(in);
    folder.protect(input_files(in));
    io::PhotoCache photos(in.scene, options.input.downscale);
    tileset::TilesetSettings settings = options.settings;
    settings.texture.device = options.common.device;
    evaluate::write_views_json(folder.file("views.json"), in.scene, in.used, in.held_out);
    const tileset::TilesetReport report = tileset::tileset_into(in.input(), settings, photos, folder, record);
    record.counts["levels"] = levels_json(report);
    if (!report.georeferenced)
      record.note("the tiles are in the scene's own coordinates, as no reference system is known");
    return {options_json(options), Json::object(), (options.out / "tileset.json").string()};
  });
}

}  // namespace gpvc::cli
