#include "app/cli/scene_input.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <future>
#include <utility>

#include "app/checks/frame_check.h"
#include "app/cli/band_notes.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/photos.h"

namespace gpvc::cli {
namespace {

void note_masks(const SceneInputData& data, RunRecord& record) {
  const auto masked = std::count_if(data.used.begin(), data.used.end(),
                                    [&](ViewId id) { return has_mask(data.scene.views[index(id)]); });
  record.counts["masked_views"] = masked;
  if (masked > 0)
    record.note(fmt::format("masks: {} of {} photos have a mask or an alpha channel", masked, data.used.size()));
}

void note_bands(const Scene& scene, RunRecord& record) {
  if (!scene.bands) return;
  for (const std::string& note : band_notes(scene)) record.note("bands: " + note);
  record.counts["bands"] = bands_json(scene);
}

void note_bad_photos(const Scene& scene, RunRecord& record) {
  Json photos = Json::array();
  for (const BadPhoto& photo : scene.bad_photos)
    photos.push_back(
        {{"view", photo.view}, {"problem", name_of(io::kPhotoProblemNames, photo.problem)}, {"reason", photo.reason}});
  record.counts["bad_photos"] = photos;
}

void append_mesh(const std::filesystem::path& file, Mesh&& more, SceneInputData& data) {
  Mesh& all = data.mesh;
  const std::size_t vertices = all.positions.size(), faces = all.faces.size();
  // The largest index means "no face".
  constexpr std::size_t kMost = 0xFFFFFFFFU;
  if (vertices + more.positions.size() > kMost || faces + more.faces.size() > kMost)
    throw InputError(file, "", "with the meshes before it, has more than 4 294 967 295 vertices or faces");
  data.parts.push_back({file, faces, more.faces.size(), vertices, more.positions.size()});
  for (std::string& warning : more.warnings) warning = file.string() + ": " + warning;
  if (faces == 0 && vertices == 0)
    all = std::move(more);
  else
    io::append_mesh(all, more);
}

void append_meshes(std::span<const std::vector<std::filesystem::path>> given, std::vector<Mesh>&& meshes,
                   SceneInputData& data) {
  auto mesh = meshes.begin();
  for (const auto& files : given)
    for (const auto& file : files) append_mesh(file, std::exchange(*mesh++, {}), data);
}

}  // namespace

void check_places(const SceneInput& input, const char* order) {
  const auto refuse_missing = [](const std::filesystem::path& file) {
    std::error_code ignored;
    if (!file.empty() && !std::filesystem::exists(file, ignored)) throw InputError(file, "", "does not exist");
  };
  // SCENE::EMBEDDING names no file, and io::read_scene() refuses it.
  if (input.scene.string().find("::") == std::string::npos) refuse_missing(input.scene);
  refuse_missing(input.mesh);
  for (const auto& more : input.more_meshes) refuse_missing(more);
  if (io::is_mesh_name(input.scene))
    throw InputError(input.scene, "", fmt::format("is a mesh, expected cameras and photos in its place: {}", order));
}

Scene read_views(const SceneInput& input, std::vector<ViewId>& used, bool allow_missing_photos) {
  io::SceneOptions reader = input.reader_options();
  reader.allow_missing_photos = allow_missing_photos;
  reader.needed = [&input](std::span<const View> all) {
    return marked(used_views(all, input.views, input.exclude_views), all.size());
  };
  Scene scene = io::read_scene(input.scene, reader);
  used = used_views(scene.views, input.views, input.exclude_views);
  if (input.skip_bad_photos) std::erase_if(used, [&](ViewId id) { return scene.views[index(id)].photo.empty(); });
  return scene;
}

SceneInputData read_scene_input(const SceneInput& input, RunRecord& record) {
  record.begin({"read"});
  check_places(input);
  SceneInputData data;
  std::vector<std::vector<std::filesystem::path>> given{io::mesh_files(input.mesh)};
  for (const auto& more : input.more_meshes) given.push_back(io::mesh_files(more));
  std::future<std::vector<Mesh>> reading =
      std::async(std::launch::async, [&given] { return io::read_meshes(given); });  // while photos are looked for
  data.scene = read_views(input, data.used);
  for (const std::string& warning : data.scene.warnings) record.warning(warning);
  data.held_out = held_out_views(data.scene, data.used, input.hold_out);
  std::erase_if(data.used,
                [&](ViewId id) { return std::binary_search(data.held_out.begin(), data.held_out.end(), id); });
  append_meshes(given, reading.get(), data);
  for (const std::string& warning : data.mesh.warnings) record.warning(warning);
  checks::prepare(data.scene, data.mesh, data.used, origin_of(input), record);
  const std::size_t all_views = data.used.size();
  if (input.preview) {
    data.used = checks::few_views(data.mesh, data.scene, data.used, kPreviewPhotosOfPlace);
    if (data.used.empty()) throw InputError(input.mesh, "", "is in no photo");
    record.note(fmt::format("a preview: {} of {} photos, in 1/{} of their width and height", data.used.size(),
                            all_views, input.reduction()));
  }
  record.counts["faces"] = data.mesh.faces.size();
  record.counts["vertices"] = data.mesh.positions.size();
  record.counts["views"] = data.scene.views.size();
  record.counts["used_views"] = data.used.size();
  note_masks(data, record);
  note_bands(data.scene, record);
  note_bad_photos(data.scene, record);
  record.counts["held_out_views"] = data.held_out.size();
  std::string of_meshes, of_views;
  if (data.parts.size() > 1) of_meshes = fmt::format(" of {} meshes", data.parts.size());
  if (data.used.size() < data.scene.views.size()) of_views = fmt::format(" of {}", data.scene.views.size());
  record.end(fmt::format("{} faces{}, {}{} views", results::readable_count(data.mesh.faces.size()), of_meshes,
                         results::readable_count(data.used.size()), of_views));
  return data;
}

checks::MeshOrigin origin_of(const SceneInput& input) { return {input.mesh, input.mesh_crs}; }

std::vector<pipeline::ViewRule> rules_of(const std::filesystem::path& allow, const SceneInputData& data,
                                         std::set<std::filesystem::path>& read) {
  if (allow.empty()) return {};
  read.insert(allow);
  return read_rules(allow, data.input());
}

Json scene_json(const SceneInput& input) {
  Json json = {{"scene", input.scene.string()}, {"mesh", input.mesh.string()}};
  if (!input.more_meshes.empty()) {
    json["more_meshes"] = Json::array();
    for (const auto& mesh : input.more_meshes) json["more_meshes"].push_back(mesh.string());
  }
  if (!input.mesh_crs.empty()) json["mesh_crs"] = input.mesh_crs;
  json["images"] = input.images_dir ? Json(input.images_dir->string()) : Json(nullptr);
  json["views"] = input.views;
  json["exclude_views"] = input.exclude_views;
  json["hold_out"] = input.hold_out;
  json["downscale"] = input.reduction();
  json["preview"] = input.preview;
  json["skip_bad_photos"] = input.skip_bad_photos;
  json["masks"] = !input.masks ? Json(false) : input.masks_dir ? Json(input.masks_dir->string()) : Json(true);
  if (!input.bands_by_name) json["bands"] = false;
  for (const io::BandFolder& band : input.bands)
    json["bands"].push_back({{"name", band.name}, {"folder", band.folder.string()}});
  if (!input.composite.empty()) json["composite"] = input.composite;
  return json;
}

Json meshes_json(const SceneInputData& input) {
  Json meshes = Json::array();
  for (const MeshPart& part : input.parts)
    meshes.push_back({{"file", part.file.string()},
                      {"first_face", part.first_face},
                      {"faces", part.faces},
                      {"first_vertex", part.first_vertex},
                      {"vertices", part.vertices}});
  return meshes;
}

std::set<std::filesystem::path> input_files(const Scene& scene) {
  namespace fs = std::filesystem;
  std::set<fs::path> files;
  for (const fs::path& file : scene.files) files.insert(fs::weakly_canonical(file));
  for (const View& view : scene.views)
    for (const fs::path& file : io::files_of(view)) files.insert(fs::weakly_canonical(file));
  return files;
}

std::set<std::filesystem::path> input_files(const SceneInputData& input) {
  std::set<std::filesystem::path> files = input_files(input.scene);
  for (const MeshPart& part : input.parts) files.insert(std::filesystem::weakly_canonical(part.file));
  return files;
}

void refuse_overwriting(const SceneInput& input, const std::filesystem::path& out,
                        const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    std::error_code ignored;
    if (std::filesystem::equivalent(out / name, input.mesh, ignored))
      throw OutputError(out / name, "is the input mesh; choose another output folder");
  }
}

}  // namespace gpvc::cli
