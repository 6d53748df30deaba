#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <optional>

#include "app/cli/options.h"
#include "io/scene_files.h"
#include "silence.h"
#include "tiny.h"

namespace gpvc::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBorder = "\n====\n";

// What precedes the first `end`, and takes both away.
std::string_view take(std::string_view& text, std::string_view end) {
  const std::size_t at = text.find(end);
  const std::string_view first = text.substr(0, at);
  text.remove_prefix(at == std::string_view::npos ? text.size() : at + end.size());
  return first;
}

// A file below the folder; nullopt for names that lead out of it.
std::optional<fs::path> place(const fs::path& folder, std::string_view name) {
  const auto is_usual = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-' || c == '/';
  };
  const fs::path path = fs::path(name).lexically_normal();
  if (name.size() > 60 || !std::ranges::all_of(name, is_usual) || path.is_absolute() || path.string().starts_with(".."))
    return std::nullopt;
  return folder / path;
}

// Paths of the scene and of the mesh, a line each, then the files: a line with the name before each, kBorder between them.
std::string packed(const std::string& scene, const std::string& mesh, const std::map<std::string, std::string>& files) {
  std::string input = scene + "\n" + mesh + "\n";
  for (const auto& [name, bytes] : files) {
    if (!input.ends_with(mesh + "\n")) input += kBorder;
    input += name + "\n" + bytes;
  }
  return input;
}

std::string ply_of(const Mesh& mesh) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.positions.size()) +
                     "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                     std::to_string(mesh.faces.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const WorldPoint& p : mesh.positions)
    text += std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  for (const Triangle& f : mesh.faces)
    text += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + "\n";
  return text;
}

// The tiny scene in every format that can be written.
void add_written(std::vector<std::string>& seeds) {
  const Scene& scene = tiny().scene;
  for (const auto& [name, target] : io::kSceneTargetNames) {
    const fs::path out = folder() / "written";
    fs::create_directories(out / "sparse");
    const std::vector<fs::path> places = io::photo_places(target, scene, tiny().views);
    for (const fs::path& place : places) fs::create_directories((out / place).parent_path());
    io::write_scene(target, scene, tiny().views, places, out);
    std::map<std::string, std::string> files{{"mesh.ply", ply_of(tiny().mesh)}};
    for (std::size_t v = 0; v < places.size(); ++v) files["scene" / places[v]] = read(scene.views[v].photo);
    for (const fs::path& file : io::listing_files(target, places)) files["scene" / file] = read(out / file);
    const std::vector<fs::path>& listings = io::scene_writer(target).files;
    seeds.push_back(packed(listings.size() == 1 ? ("scene" / listings[0]).string() : "scene", "mesh.ply", files));
    fs::remove_all(out);
  }
}

// The smallest seed of other targets: each scene's with an OBJ, each mesh's with the tiny scene.
void add_corpora(const fs::path& corpus, std::vector<std::string>& seeds) {
  const auto smallest = [&](const char* target) {
    fs::path best;
    for (const fs::directory_entry& entry : fs::directory_iterator(corpus / target))
      if (best.empty() || entry.file_size() < fs::file_size(best)) best = entry.path();
    return read(best);
  };
  const std::string obj = smallest("obj"), scene = smallest("transforms");
  for (const auto& [target, name] : {std::pair{"alicevision", "cameras.sfm"},
                                     {"blocks_exchange", "blocks.xml"},
                                     {"bundler", "bundle.out"},
                                     {"cam", "one.cam"},
                                     {"metashape", "cameras.xml"},
                                     {"nvm", "scene.nvm"},
                                     {"openmvg", "sfm_data.json"},
                                     {"openmvs", "scene.mvs"},
                                     {"opensfm", "reconstruction.json"},
                                     {"pix4d", "p_calibrated_camera_parameters.txt"},
                                     {"reality_csv", "cameras.csv"},
                                     {"reality_xmp", "one.xmp"}})
    seeds.push_back(packed(name, "mesh.obj", {{name, smallest(target)}, {"mesh.obj", obj}}));
  for (const auto& [target, name] :
       {std::pair{"glb", "mesh.glb"}, {"off", "mesh.off"}, {"ply", "mesh.ply"}, {"stl", "mesh.stl"}})
    seeds.push_back(packed("transforms.json", name, {{"transforms.json", scene}, {name, smallest(target)}}));
}

std::vector<std::string> inspect_seeds(const fs::path& corpus) {
  std::vector<std::string> seeds;
  add_written(seeds);
  if (!corpus.empty()) add_corpora(corpus, seeds);
  return seeds;
}

}  // namespace

// `gpvc inspect` of files that lie together.
GPVC_FUZZ_TARGET(inspect, inspect_seeds) {
  const fs::path input = folder() / "input";
  fs::remove_all(input);
  fs::create_directories(input);
  std::string_view rest = view(data, size);
  const auto scene = place(input, take(rest, "\n")), mesh = place(input, take(rest, "\n"));
  while (!rest.empty()) {
    std::string_view bytes = take(rest, kBorder);
    const auto file = place(input, take(bytes, "\n"));
    std::error_code failed;
    if (file) fs::create_directories(file->parent_path(), failed);
    if (file) std::ofstream(*file, std::ios::binary) << bytes;
  }
  if (!scene || !mesh) return 0;
  cli::InspectOptions options;
  options.input.scene = *scene;
  options.input.mesh = *mesh;
  options.plan = size % 2 == 0;
  const Silence silence;
  cli::Console console(cli::Loudness::quiet, {});
  return succeeds_or_fails([&] { cli::run_inspect(options, console); });
}

}  // namespace gpvc::fuzz
