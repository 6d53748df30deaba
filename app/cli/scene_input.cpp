#include "app/cli/scene_input.h"

#include <fmt/format.h>
#include <fnmatch.h>
#include <tbb/info.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <future>

#include "app/cli/lens_json.h"
#include "app/cli/near_words.h"
#include "app/pipeline/frame_check.h"

namespace gpvc::cli {
namespace {

void note_masks(const SceneInputData& data, Console& console, RunRecord& record) {
  const auto masked = std::count_if(data.used.begin(), data.used.end(), [&](ViewId id) {
    const View& view = data.scene.views[index(id)];
    return !view.mask.empty() || view.uses_alpha;
  });
  record.counts["masked_views"] = masked;
  if (masked > 0)
    console.note(fmt::format("masks: {} of {} photos have a mask or an alpha channel", masked, data.used.size()));
}

std::vector<std::string> listed(const std::string& list) {
  std::vector<std::string> names;
  if (list.starts_with("@")) {
    std::ifstream in(list.substr(1));
    if (!in) throw InputError(list.substr(1), "", "cannot be read as a list of views");
    for (std::string line; std::getline(in, line);) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (!line.empty()) names.push_back(line);
    }
    return names;
  }
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t comma = std::min(list.find(',', at), list.size());
    if (comma > at) names.push_back(list.substr(at, comma - at));
    at = comma + 1;
  }
  return names;
}

std::string near_names(std::span<const View> views, const std::string& name) {
  std::vector<std::string> names;
  for (const View& view : views) names.push_back(view.name);
  std::string text;
  for (const std::string& near : near_words(name, names, 3)) text += (text.empty() ? "" : ", ") + near;
  return text;
}

// What a LIST's entry may be, the plainest reading that fits winning: a name as it stands, a glob, a name without its
// extension.
enum class Reading { name, glob, stem };

bool fits(const std::string& entry, const std::string& view, Reading reading) {
  if (reading == Reading::name) return view == entry;
  if (reading == Reading::glob) return fnmatch(entry.c_str(), view.c_str(), 0) == 0;
  return std::filesystem::path(view).replace_extension() == std::filesystem::path(entry);
}

std::vector<bool> matched(std::span<const View> views, const std::string& option, const std::string& list) {
  std::vector<bool> hit(views.size(), false);
  for (const std::string& entry : listed(list)) {
    std::vector<std::size_t> found;
    for (const Reading reading : {Reading::name, Reading::glob, Reading::stem}) {
      if (!found.empty()) break;
      for (std::size_t v = 0; v < views.size(); ++v)
        if (fits(entry, views[v].name, reading)) found.push_back(v);
      if (reading == Reading::stem && found.size() > 1)
        throw UsageError(fmt::format("{}: '{}' may be {} or {}; give the extension", option, entry,
                                     views[found[0]].name, views[found[1]].name));
    }
    if (found.empty())
      throw UsageError(
          fmt::format("{}: the scene has no view '{}'; near are {}", option, entry, near_names(views, entry)));
    for (const std::size_t v : found) hit[v] = true;
  }
  return hit;
}

// Appends a mesh, its vertices and faces following those there.
void append_mesh(const std::filesystem::path& file, Mesh&& more, SceneInputData& data) {
  Mesh& all = data.mesh;
  const std::size_t vertices = all.positions.size(), faces = all.faces.size();
  // One index below the largest means "no face".
  constexpr std::size_t kMost = 0xFFFFFFFFU;
  if (vertices + more.positions.size() > kMost || faces + more.faces.size() > kMost)
    throw InputError(file, "", "with the meshes before it, has more than 4 294 967 295 vertices or faces");
  data.parts.push_back({file, faces, more.faces.size(), vertices, more.positions.size()});
  if (faces == 0 && vertices == 0) {
    all = std::move(more);
    return;
  }
  io::append_mesh(all, more);
}

Json point_json(const WorldPoint& p) { return Json::array({p.x, p.y, p.z}); }

}  // namespace

std::vector<ViewId> used_views(std::span<const View> all, const std::string& views, const std::string& exclude_views) {
  std::vector<bool> wanted(all.size(), true), excluded(all.size(), false);
  if (!views.empty()) wanted = matched(all, "--views", views);
  if (!exclude_views.empty()) excluded = matched(all, "--exclude-views", exclude_views);
  std::vector<ViewId> used;
  for (std::size_t v = 0; v < all.size(); ++v)
    if (wanted[v] && !excluded[v]) used.push_back(ViewId{static_cast<std::uint32_t>(v)});
  if (used.empty()) throw UsageError("--views and --exclude-views leave no view");
  return used;
}

std::function<std::vector<bool>(std::span<const View>)> needs_used_views(std::string views, std::string exclude_views) {
  return [views = std::move(views), exclude_views = std::move(exclude_views)](std::span<const View> all) {
    std::vector<bool> needed(all.size(), false);
    for (const ViewId id : used_views(all, views, exclude_views)) needed[index(id)] = true;
    return needed;
  };
}

std::vector<ViewId> held_out_views(const Scene& scene, std::span<const ViewId> used, const std::string& hold_out) {
  std::vector<ViewId> held;
  if (hold_out.empty()) return held;
  const bool named =
      std::any_of(scene.views.begin(), scene.views.end(), [&](const View& view) { return view.name == hold_out; });
  std::size_t every = 0;
  const char* end = hold_out.data() + hold_out.size();
  const auto [parsed, failed] = std::from_chars(hold_out.data(), end, every);
  if (!named && failed == std::errc{} && parsed == end) {
    if (every < 2)
      throw UsageError(fmt::format("--hold-out {}: every K-th view is held out, and K is 2 or more", hold_out));
    for (std::size_t n = every - 1; n < used.size(); n += every) held.push_back(used[n]);
    if (held.empty()) throw UsageError(fmt::format("--hold-out {}: there are only {} views", hold_out, used.size()));
    return held;
  }
  const std::vector<bool> hit = matched(scene.views, "--hold-out", hold_out);
  std::copy_if(used.begin(), used.end(), std::back_inserter(held), [&](ViewId id) { return hit[index(id)]; });
  if (held.empty()) throw UsageError("--hold-out names only views that --views and --exclude-views leave out");
  if (held.size() == used.size()) throw UsageError("--hold-out leaves no view to texture from");
  return held;
}

std::vector<std::string> marked_views(const std::filesystem::path& model, const std::string& mark) {
  std::vector<std::string> names;
  std::ifstream in(model.parent_path() / "views.json");
  const Json json = Json::parse(in, nullptr, false);
  if (!json.is_object() || !json.contains("views") || !json["views"].is_array()) return names;
  for (const Json& view : json["views"])
    if (view.is_object() && view.contains("name") && view["name"].is_string() && view.contains(mark) &&
        view[mark] == true)
      names.push_back(view["name"].get<std::string>());
  return names;
}

SceneInputData read_scene_input(const SceneInput& input, Console& console, RunRecord& record) {
  Stage stage(console, record, "read");
  SceneInputData data;
  std::vector<std::filesystem::path> files{input.mesh};
  files.insert(files.end(), input.more_meshes.begin(), input.more_meshes.end());
  std::vector<std::future<Mesh>> meshes;
  for (const auto& file : files)
    meshes.push_back(std::async(std::launch::async, [&file] { return io::read_mesh(file); }));
  io::SceneOptions reader = input.reader_options();
  reader.needed = needs_used_views(input.views, input.exclude_views);
  data.scene = io::read_scene(input.scene, reader);
  for (const std::string& warning : data.scene.warnings) console.warning(warning);
  data.used = used_views(data.scene.views, input.views, input.exclude_views);
  data.held_out = held_out_views(data.scene, data.used, input.hold_out);
  std::erase_if(data.used,
                [&](ViewId id) { return std::binary_search(data.held_out.begin(), data.held_out.end(), id); });
  for (std::size_t m = 0; m < files.size(); ++m) append_mesh(files[m], meshes[m].get(), data);
  pipeline::check_frames(data.mesh, input.mesh, data.scene, data.used);
  const std::string winding =
      pipeline::check_winding(pipeline::back_share(data.mesh, data.scene, data.used), input.mesh);
  if (!winding.empty()) console.warning(winding);
  record.counts["faces"] = data.mesh.faces.size();
  record.counts["vertices"] = data.mesh.positions.size();
  record.counts["views"] = data.scene.views.size();
  record.counts["used_views"] = data.used.size();
  note_masks(data, console, record);
  record.counts["held_out_views"] = data.held_out.size();
  const std::string views = data.used.size() == data.scene.views.size()
                                ? readable_count(data.used.size())
                                : fmt::format("{} of {}", data.used.size(), data.scene.views.size());
  const std::string of_meshes = data.parts.size() == 1 ? "" : fmt::format(" of {} meshes", data.parts.size());
  stage.finish(fmt::format("{} faces{}, {} views", readable_count(data.mesh.faces.size()), of_meshes, views));
  return data;
}

void write_views_json(const std::filesystem::path& file, const SceneInputData& input) {
  Json views = Json::array();
  for (std::size_t v = 0; v < input.scene.views.size(); ++v) {
    const View& view = input.scene.views[v];
    const ViewId id{static_cast<std::uint32_t>(v)};
    const Camera& c = view.camera;
    const auto& r = view.pose.rotation;
    views.push_back({{"index", v},
                     {"name", view.name},
                     {"photo", view.photo.string()},
                     {"used", std::binary_search(input.used.begin(), input.used.end(), id)},
                     {"held_out", std::binary_search(input.held_out.begin(), input.held_out.end(), id)},
                     {"width", c.width},
                     {"height", c.height},
                     {"fx", c.fx},
                     {"fy", c.fy},
                     {"cx", c.cx},
                     {"cy", c.cy},
                     {"distortion", lens_json(c.distortion)},
                     {"rotation", Json::array({Json::array({r[0], r[1], r[2]}), Json::array({r[3], r[4], r[5]}),
                                               Json::array({r[6], r[7], r[8]})})},
                     {"centre", point_json(view.pose.centre)}});
  }
  const Json json = {{"scene", input.scene.source.string()},
                     {"convention",
                      "x_camera = rotation * (x_world - centre); x right, y down, z forward; pixels from the top-left "
                      "corner, first centre at (0.5, 0.5); distortion as in OpenCV, further models as in io/scene.h"},
                     {"format", input.scene.format},
                     {"srs", input.scene.srs.empty() ? Json(nullptr) : Json(input.scene.srs)},
                     {"srs_offset", point_json(input.scene.offset)},
                     {"views", views}};
  write_text_file(file, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

Json device_json(const visibility::DeviceInfo& device) {
  return {
      {"index", device.index}, {"renderer", device.renderer}, {"driver", device.driver}, {"software", device.software}};
}

Json visibility_json(const visibility::VisibilityOptions& options) {
  constexpr const char* kCorrections[] = {"off", "paper", "exact"};
  constexpr const char* kClassifiers[] = {"auto", "cpu", "gpu"};
  constexpr const char* kDrawings[] = {"auto", "opengl", "native"};
  return {{"visibility", visibility::visibility_mode_name(options)},
          {"projection", options.projection == visibility::Projection::spc ? "spc" : "apc"},
          {"coverage_correction", kCorrections[static_cast<std::size_t>(options.correction)]},
          {"classifier", kClassifiers[static_cast<std::size_t>(options.classifier)]},
          {"drawing", kDrawings[static_cast<std::size_t>(options.drawing)]},
          {"subpixel", options.subpixel}};
}

Json scene_json(const SceneInput& input) {
  Json json = {{"scene", input.scene.string()}, {"mesh", input.mesh.string()}};
  if (!input.more_meshes.empty()) {
    json["more_meshes"] = Json::array();
    for (const auto& mesh : input.more_meshes) json["more_meshes"].push_back(mesh.string());
  }
  json["images"] = input.images_dir ? Json(input.images_dir->string()) : Json(nullptr);
  json["views"] = input.views;
  json["exclude_views"] = input.exclude_views;
  json["hold_out"] = input.hold_out;
  json["downscale"] = input.downscale;
  json["masks"] = !input.masks ? Json(false) : input.masks_dir ? Json(input.masks_dir->string()) : Json(true);
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

void write_run_json(pipeline::OutputFolder& folder, const RunFacts& facts, const RunRecord& record) {
  const auto file = folder.file("run.json");
  double wall = 0, cpu = 0;
  for (const Json& stage : record.stages) {
    wall += stage["wall_s"].get<double>();
    cpu += stage["cpu_s"].get<double>();
  }
  const int threads = facts.common.threads > 0 ? facts.common.threads : tbb::info::default_concurrency();
  const Json json = {{"program", "gpvc"},
                     {"version", program_version()},
                     {"command", facts.command},
                     {"command_line", facts.common.command_line},
                     {"options", facts.options},
                     {"threads", threads},
                     {"device", facts.device},
                     {"stages", record.stages},
                     {"wall_s", wall},
                     {"cpu_s", cpu},
                     {"peak_resident_bytes", peak_resident_bytes()},
                     {"counts", record.counts},
                     {"outputs", pipeline::outputs_json(folder.promised())}};
  write_text_file(file, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::set<std::filesystem::path> input_files(const Scene& scene) {
  namespace fs = std::filesystem;
  std::set<fs::path> files;
  for (const fs::path& file : scene.files) files.insert(fs::weakly_canonical(file));
  for (const View& view : scene.views)
    for (const fs::path& file : {view.photo, view.mask})
      if (!file.empty()) files.insert(fs::weakly_canonical(file));
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

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  io::OutputFile out(file);
  out.write(text);
  out.commit();
}

}  // namespace gpvc::cli
