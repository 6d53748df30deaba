// gpvc ortho: a true orthophoto of a result, or of a scene that it textures.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <optional>

#include "app/cli/scene_input.h"
#include "app/cli/setting_options.h"
#include "app/ortho/ortho.h"
#include "app/pipeline/texture_files.h"
#include "io/photos.h"

namespace gpvc::cli {
namespace {

namespace fs = std::filesystem;

Json options_json(const OrthoCommandOptions& o) {
  Json json = scene_json(o.input);
  json.update(settings_json(o.settings, options_for(pipeline::For::one_process)));
  json.update(settings_json(o.ortho));
  json["allow"] = o.allow.string();
  json["from"] = o.from.string();
  return json;
}

// The up direction that the cameras of a result tell, which they do where they look at anything but all around.
std::optional<WorldPoint> up_of_result(const fs::path& model) {
  Scene scene;
  for (const Pose& pose : used_poses(model))
    scene.views.push_back({.name = "", .photo = {}, .camera = {}, .pose = pose});
  if (scene.views.empty()) return std::nullopt;
  return pipeline::up_direction(scene, all_views(scene));
}

ortho::Surface surface_of_result(const OrthoCommandOptions& options, ortho::PageStore& pages, RunRecord& record,
                                 pipeline::OutputFolder& folder) {
  record.begin({"read"});
  if (!options.input.scene.empty()) record.note("SCENE and MESH are not read: all is in the result that is drawn");
  results::OutputFolder::finish_interrupted(options.from);
  const std::vector<fs::path> models = ortho::models_of(options.from);
  std::set<fs::path> read;
  for (const fs::path& model : models)
    for (const fs::path& file : {model, model.parent_path() / "labels.npy", model.parent_path() / "tags.npy"})
      read.insert(fs::weakly_canonical(file));
  folder.protect(read);
  ortho::Surface surface = ortho::read_surface(models, options.settings.atlas.unseen, pages);
  for (const std::string& warning : surface.mesh.warnings) record.warning(warning);
  std::string& srs = surface.coordinates.srs;
  if (!options.input.mesh_crs.empty() && !srs.empty() && srs != options.input.mesh_crs)
    throw InputError(options.from, "",
                     fmt::format("has the coordinates of {}, not of {}", srs, options.input.mesh_crs));
  if (srs.empty()) srs = options.input.mesh_crs;
  surface.up = up_of_result(models.front());
  surface.photos = listed_views(models.front());
  record.counts["faces"] = surface.mesh.faces.size();
  record.end(fmt::format("{} faces, {} pages", results::readable_count(surface.mesh.faces.size()), pages.size()));
  return surface;
}

ortho::TexturedSurface surface_of_scene(const OrthoCommandOptions& options, ortho::PageStore& pages, RunRecord& record,
                                        pipeline::OutputFolder& folder) {
  const SceneInputData in = read_scene_input(options.input, record);
  pipeline::Settings settings = options.settings;
  std::set<fs::path> read = input_files(in);
  settings.view_rules = rules_of(options.allow, in, read);
  settings.device = options.common.device;
  folder.protect(read);
  io::PhotoCache photos(in.scene);
  const pipeline::Input input = in.input();
  evaluate::write_views_json(folder.file("views.json"), in.scene, in.used, in.held_out);
  try {
    return ortho::texture_surface({input, settings, photos, record}, pages, folder);
  } catch (const pipeline::MemoryError& too_little) {
    throw pipeline::MemoryError(
        fmt::format("{}; gpvc tiles and gpvc unit texture it in parts, of which --from draws the result",
                    too_little.what()),
        too_little.cures(), too_little.measures());
  }
}

}  // namespace

void run_ortho(const OrthoCommandOptions& options, Console& console) {
  const bool has_scene = !options.input.scene.empty() && !options.input.mesh.empty();
  if (options.from.empty() && !has_scene)
    throw UsageError(options.input.scene.empty() ? "SCENE and MESH are missing, or --from with what is textured already"
                                                 : "MESH is missing after SCENE");
  if (options.from.empty()) note_kept_work(options, options.settings, console);
  run_command("ortho", options, console, [&](RunRecord& record, pipeline::OutputFolder& folder) -> RunFacts {
    ortho::PageStore pages(folder.in_making());
    const bool from_photos = options.from.empty();
    auto [surface, device] =
        from_photos ? surface_of_scene(options, pages, record, folder)
                    : ortho::TexturedSurface{surface_of_result(options, pages, record, folder), std::nullopt};
    const ortho::Frame frame = ortho::place_surface(surface, options.ortho);
    ortho::write_ortho(surface, pages, frame, options.ortho, folder, record);
    return {options_json(options), from_photos ? evaluate::device_json(device) : Json::object(),
            (options.out / ortho::kOrthoFile).string()};
  });
}

}  // namespace gpvc::cli
