// gpvc texture and gpvc tileset: each reads its input, runs the library, writes the result.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <deque>
#include <optional>

#include "app/cli/cures.h"
#include "app/cli/layer_input.h"
#include "app/cli/scene_input.h"
#include "app/cli/setting_options.h"
#include "app/pipeline/memory.h"
#include "app/tiles/local_run.h"

namespace gpvc::cli {
namespace {

Json options_json(const TextureOptions& o) {
  Json json = scene_json(o.input);
  json.update(settings_json(o.settings, options_for(pipeline::For::one_model)));
  json["allow"] = o.allow.string();
  json["from"] = o.from.string();
  json["keep_uv"] = o.keep_uv;
  json["layers"] = Json::array();
  for (const std::filesystem::path& folder : o.layers) json["layers"].push_back(folder.string());
  json["level_layers"] = o.level_layers;
  json["editable"] = o.settings.editable || !o.from.empty();
  return json;
}

Json options_json(const TilesetOptions& o) {
  Json json = scene_json(o.input);
  json.update(settings_json(o.settings, options_for(pipeline::For::one_process)));
  json.update(settings_json(o.tiles));
  json["allow"] = o.allow.string();
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

// What each photo was multiplied by, by view: `gain` of the channels, and exp(k1 r^2 + k2 r^4) for what its lens takes away at a
// distance r from the middle, 1 in the corner.
Json exposure_json(std::span<const atlas::ViewExposure> exposure) {
  Json views = Json::array();
  for (const atlas::ViewExposure& each : exposure)
    views.push_back({{"gain", each.gain}, {"k1", each.k1}, {"k2", each.k2}});
  return views;
}

// What has no meaning for a result in tiles.
bool needs_one_model(const TextureOptions& o) {
  const pipeline::Settings& s = o.settings;
  return s.editable || !o.from.empty() || o.keep_uv || !o.layers.empty() || s.atlas.max_pages > 0 ||
         s.atlas.max_texels > 0 || s.atlas.band_gains || s.output.max_bytes > 0;
}

// What was asked for and tiles do not have: the end of a sentence.
std::string without_in_tiles(const TextureOptions& o) {
  const bool files = o.settings.output.gltf != io::GltfContainer::glb;
  if (!o.settings.output.normals && !files) return "";
  return fmt::format(", without {}{}{}", o.settings.output.normals ? "normals" : "",
                     o.settings.output.normals && files ? " and " : "", files ? "model.gltf" : "");
}

// The input of a command that textures, with its settings for this machine and this scene.
struct TextureInput {
  SceneInputData scene;
  pipeline::Settings settings;
};
TextureInput read_input(const SceneInput& input, const std::filesystem::path& allow, const pipeline::Settings& settings,
                        int device, RunRecord& record, pipeline::OutputFolder& folder) {
  TextureInput in{read_scene_input(input, record), settings};
  std::set<std::filesystem::path> read = input_files(in.scene);
  in.settings.view_rules = rules_of(allow, in.scene, read);
  in.settings.device = device;
  folder.protect(read);
  return in;
}

// Throws UsageError for options that exclude --keep-uv, or belong to it.
void check_keep_uv(const TextureOptions& o) {
  if (!o.keep_uv) {
    if (o.settings.overlap != pipeline::Overlap::once) throw UsageError("--overlap belongs to --keep-uv");
    return;
  }
  const atlas::AtlasOptions& atlas = o.settings.atlas;
  const auto refuse = [](bool given, const char* option, const char* why) {
    if (given) throw UsageError(fmt::format("--keep-uv does not go with {}: {}", option, why));
  };
  refuse(atlas.max_pages > 0, "--max-pages", "the texture coordinates say how many pages there are");
  refuse(atlas.max_texels > 0, "--max-texels", "pages are as large as their images, or as --page-size says");
  refuse(atlas.texel_size > 0, "--texel-size", "pages are as large as their images, or as --page-size says");
  refuse(!o.input.more_meshes.empty(), "several meshes", "expected one file with texture coordinates");
}

// The layout of the mesh's own texture coordinates.
io::UvLayout read_layout(const TextureOptions& o, const Mesh& mesh) {
  const io::StatedUv uv = io::read_uv(o.input.mesh);
  if (uv.face_texcoords.size() != mesh.faces.size())
    throw InputError(o.input.mesh, "",
                     fmt::format("has {} faces with texture coordinates and {} without them", uv.face_texcoords.size(),
                                 mesh.faces.size()));
  return io::lay_out(uv, {o.settings.atlas.page_size, !o.sizes_pages}, o.input.mesh);
}

void write_views(const SceneInputData& in, pipeline::OutputFolder& folder) {
  evaluate::write_views_json(folder.file("views.json"), in.scene, in.used, in.held_out);
}

}  // namespace

void run_texture(const TextureOptions& options, Console& console, results::Observer* watcher) {
  refuse_contradictions(options.settings);
  check_keep_uv(options);
  if (options.level_layers && options.layers.empty()) throw UsageError("--level-layers belongs to --layers");
  refuse_overwriting(options.input, options.out, {"model.obj", "model.glb", "model.gltf"});
  note_kept_work(options, options.settings, console);
  const auto steps = [&](RunRecord& record, pipeline::OutputFolder& folder) -> RunFacts {
    if (!options.from.empty()) pipeline::OutputFolder::finish_interrupted(options.from);
    const auto [in, given] =
        read_input(options.input, options.allow, options.settings, options.common.device, record, folder);
    TextureOptions done = options;
    done.settings = pipeline::with_target(given, in.mesh.faces.size(), options.keep_uv);
    io::PhotoCache photos(in.scene);
    write_views(in, folder);
    pipeline::Input input = in.input();
    std::optional<io::UvLayout> layout;
    if (options.keep_uv) input.layout = &layout.emplace(read_layout(options, in.mesh));
    const std::vector<LayerInput> layer_input = read_layers(options.layers, options.input, in, record);
    std::deque<io::PhotoCache> layer_caches;
    std::vector<pipeline::LayerPhotos> layers;
    for (const LayerInput& layer : layer_input) {
      folder.protect(input_files(layer.scene));
      layers.push_back({layer.name, layer.scene, layer_caches.emplace_back(layer.scene), options.level_layers});
    }
    const pipeline::Run run{input, done.settings, photos, record};
    std::optional<pipeline::TexturedFiles> files;
    try {
      files = options.from.empty() ? pipeline::texture_into(run, folder, layers)
                                   : pipeline::retexture_into(options.from, run, folder, layers);
    } catch (const pipeline::MemoryError& too_little) {
      if (needs_one_model(options)) throw;
      record.warning(fmt::format("{}. It goes on in tiles, one after another: the result is tileset.json{}",
                                 with_cures(too_little.what(), too_little.cures()), without_in_tiles(options)));
      folder.start_over();
      write_views(in, folder);
      tiles::texture_in_tiles({input, given, photos, record}, program_version(), folder);
      done.settings = given;
      done.settings.output.normals = false;
      done.settings.output.gltf = io::GltfContainer::glb;
      return {options_json(done), Json::object(), (options.out / "tileset.json").string()};
    }
    const auto& [textured, written] = *files;
    if (!textured.atlas.exposure.empty()) record.counts["exposure"] = exposure_json(textured.atlas.exposure);
    record.counts["preview"] = preview_json(written);
    record.counts["up"] = name_of(io::kUpAxisNames, written.up);
    record.counts["offset"] = evaluate::point_json(written.offset);
    std::string models;
    for (const char* name : {"model.obj", "model.glb", "model.gltf", "preview.png"})
      if (std::ranges::count(folder.promised(), name) > 0)
        models += (models.empty() ? "" : "\n") + (options.out / name).string();
    return {options_json(done), evaluate::device_json(textured.device), models};
  };
  run_command("texture", options, console, steps, watcher);
  tiles::remove_job(options.out);
}

void run_tileset(const TilesetOptions& options, Console& console) {
  refuse_contradictions(options.settings);
  refuse_overwriting(options.input, options.out, {"tileset.json"});
  note_kept_work(options, options.settings, console);
  run_command("tileset", options, console, [&](RunRecord& record, pipeline::OutputFolder& folder) -> RunFacts {
    const auto [in, settings] =
        read_input(options.input, options.allow, options.settings, options.common.device, record, folder);
    io::PhotoCache photos(in.scene);
    write_views(in, folder);
    const pipeline::Input input = in.input();
    const tileset::TilesetReport report =
        tileset::tileset_into({input, settings, photos, record}, options.tiles, folder);
    record.counts["levels"] = levels_json(report);
    if (!report.placing.empty()) record.note(report.placing);
    return {options_json(options), Json::object(), (options.out / "tileset.json").string()};
  });
}

}  // namespace gpvc::cli
