// Spoils a scene that is right in the ways that scenes of users are wrong, textures each, and tells which of them the
// program refused, warned of or took without a word; and whether it warned of the right one, whole or with fewer views.
#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <utility>

#include "app/synth/synth_scene.h"
#include "benchmarks/child.h"
#include "benchmarks/command.h"
#include "benchmarks/table.h"
#include "benchmarks/wrong_scenes.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/scene_files.h"
#include "io/tie_points.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path scene, mesh, images, folder, gpvc;
  int subsets = 3;
  std::string only;                  ///< mistakes whose names contain it
  std::vector<std::string> options;  ///< given to gpvc texture
};

std::vector<Mistake> mistakes() {
  std::vector<Mistake> all = mistakes_of_views();
  std::ranges::move(mistakes_of_photos(), std::back_inserter(all));
  std::ranges::move(mistakes_of_meshes(), std::back_inserter(all));
  return all;
}

// --- files

/// points3D.bin, with the numbers that write_scene gives to images: so the points stay a witness of the right poses.
void write_points(const fs::path& file, const std::vector<io::TiePoint>& points) {
  std::ofstream out(file, std::ios::binary);
  const auto add = [&](auto value) {
    std::array<char, sizeof value> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    out.write(bytes.data(), sizeof value);
  };
  add(std::uint64_t{points.size()});
  for (std::size_t n = 0; n < points.size(); ++n) {
    const io::TiePoint& point = points[n];
    add(std::uint64_t{n + 1});
    for (const double v : {point.position.x, point.position.y, point.position.z}) add(v);
    for (int channel = 0; channel < 3; ++channel) add(std::uint8_t{128});
    add(0.0);  // error
    add(std::uint64_t{2});
    for (const ViewId view : {point.a, point.b}) {
      add(static_cast<std::uint32_t>(index(view) + 1));
      add(std::uint32_t{0});
    }
  }
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

/// images.bin as write_scene leaves it, without points, gets those that the right cameras show.
void add_sightings(const fs::path& file, const Scene& right, const std::vector<io::TiePoint>& points) {
  std::vector<std::string> lists(right.views.size());
  std::vector<std::uint64_t> counts(right.views.size(), 0);
  const auto append = [](std::string& bytes, auto value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (std::size_t n = 0; n < points.size(); ++n)
    for (const ViewId id : {points[n].a, points[n].b}) {
      const auto at = photo_from_world(right.views[index(id)], points[n].position);
      if (!at) continue;
      append(lists[index(id)], at->x);
      append(lists[index(id)], at->y);
      append(lists[index(id)], std::uint64_t{n + 1});
      ++counts[index(id)];
    }
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::string out = bytes.substr(0, 8);
  std::size_t at = 8;
  for (std::size_t v = 0; v < right.views.size(); ++v) {
    constexpr std::size_t kPose = 4 + 7 * 8 + 4, kCount = 8;
    const std::size_t end = bytes.find('\0', at + kPose) + 1;
    out += bytes.substr(at, end - at);
    append(out, counts[v]);
    out += lists[v];
    at = end + kCount;
  }
  write_text(file, out);
}

void write_model(const fs::path& folder, const Scene& scene, const std::vector<io::TiePoint>& points) {
  fs::create_directories(folder / "sparse");
  const std::vector<ViewId> all = all_views(scene);
  const auto places = io::photo_places(io::SceneTarget::colmap, scene, all);
  io::write_scene(io::SceneTarget::colmap, scene, all, places, folder);
  write_points(folder / "sparse" / "points3D.bin", points);
}

/// The photos of a scene, some of them others.
void write_photos(const fs::path& folder, const Scene& scene, const OtherPhotos& others) {
  fs::remove_all(folder);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    const fs::path file = folder / view.name;
    fs::create_directories(file.parent_path());
    if (const auto other = others.find(v); other != others.end())
      io::write_image(file, other->second, file.extension() == ".png" ? io::ImageFormat::png : io::ImageFormat::jpg,
                      95);
    else
      fs::create_symlink(fs::absolute(view.photo), file);
  }
}

// --- runs

struct Outcome {
  std::string ended;           ///< "refused", "textured"
  std::set<std::string> says;  ///< warnings and errors
};

/// A scene on disk.
struct Files {
  fs::path scene, mesh, images;
  double texel_size = 0;
};

/// What is wrong is said before anything is painted, which is made as quick as can be: charts of a few texels.
Outcome texture(const Arguments& arguments, const Files& files, const std::string& without) {
  const fs::path model = arguments.folder / "model", log = arguments.folder / "log.txt";
  std::vector<std::string> words{arguments.gpvc.string(),
                                 "texture",
                                 files.scene.string(),
                                 files.mesh.string(),
                                 "--images",
                                 files.images.string(),
                                 "-o",
                                 model.string(),
                                 "--force",
                                 "--quiet",
                                 "--no-resume",
                                 "--seams",
                                 "none",
                                 "--blend",
                                 "none",
                                 "--texel-size",
                                 fmt::format("{}", files.texel_size)};
  words.insert(words.end(), arguments.options.begin(), arguments.options.end());
  if (!without.empty()) words.insert(words.end(), {"--exclude-views", without});
  const Ended ended = run_program(words, log);
  fs::remove_all(model);
  const bool clean = WIFEXITED(ended.status);
  if (!clean || WEXITSTATUS(ended.status) > 1)
    throw std::runtime_error(
        fmt::format("{} ended with {}; its output is in {}", words[0], how_ended(ended.status), log.string()));
  Outcome outcome{ended.status == 0 ? "textured" : "refused", {}};
  std::ifstream lines(log);
  constexpr const char* kPrefix = "gpvc: ";
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(kPrefix)) outcome.says.insert(line.substr(std::strlen(kPrefix)));
  return outcome;
}

/// What was said here and not of the right scene, shortened: what explains it comes last.
std::string news(const Outcome& outcome, const Outcome& right) {
  constexpr std::size_t kMost = 200;
  constexpr std::string_view kBefore = "do not fit together: ";
  std::string text;
  for (std::string line : outcome.says) {
    if (right.says.contains(line)) continue;
    if (const std::size_t at = line.find(kBefore); at != std::string::npos) line.erase(0, at + kBefore.size());
    if (line.size() > kMost) line = line.substr(0, kMost) + " ...";
    text += (text.empty() ? "" : " // ") + line;
  }
  std::ranges::replace(text, '|', '/');
  return text;
}

/// A random half, third or quarter of the views is kept, but at least three, which can judge each other.
std::string random_rest(const Scene& scene, std::size_t share, std::mt19937& random) {
  std::vector<std::string> names;
  for (const View& view : scene.views) names.push_back(view.name);
  std::shuffle(names.begin(), names.end(), random);
  names.erase(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(std::min(
                                                 names.size(), std::max<std::size_t>(3, names.size() / share))));
  return fmt::format("{}", fmt::join(names, ","));
}

int run(Arguments arguments) {
  if (!fs::is_regular_file(arguments.gpvc))
    throw std::invalid_argument(arguments.gpvc.string() + ": no such program; --gpvc names it");
  io::SceneOptions options;
  if (!arguments.images.empty()) options.images_dir = arguments.images;
  const Input right{io::read_scene(arguments.scene, options), io::read_mesh(arguments.mesh)};
  if (right.scene.views.size() < 4) throw std::invalid_argument("a scene of four views or more is needed");
  if (arguments.images.empty()) {
    // The folder that all photos share, by their names below it.
    const View& view = right.scene.views[0];
    const std::string photo = view.photo.generic_string();
    if (!photo.ends_with(view.name)) throw std::invalid_argument("--images is needed for this scene");
    arguments.images = photo.substr(0, photo.size() - view.name.size());
  }
  const std::vector<io::TiePoint> points = io::read_tie_points(right.scene, 20000);
  fs::create_directories(arguments.folder);
  const fs::path photos = arguments.folder / "photos";
  Files files{arguments.folder / "scene", arguments.folder / "mesh.ply", arguments.images};

  Table table({"scene", "ended", "says"});
  std::size_t silent = 0, wrong = 0;
  const auto write = [&](const Input& input, bool sightings) {
    write_model(files.scene, input.scene, points);
    if (sightings) add_sightings(files.scene / "sparse" / "images.bin", right.scene, points);
    synth::write_synth_mesh(files.mesh, input.mesh, {});
    files.texel_size = extent_of(input.mesh) / 50;
  };
  write(right, true);
  const Outcome normal = texture(arguments, files, "");
  table.add({"right", normal.ended, news(normal, {})});
  std::mt19937 random(7);
  std::size_t runs = 0, alarms = 0;
  for (const std::size_t share : {2u, 3u, 4u})
    for (int n = 0; n < arguments.subsets; ++n) {
      const std::string without = random_rest(right.scene, share, random);
      const Outcome outcome = texture(arguments, files, without);
      ++runs;
      const std::string says = news(outcome, normal);
      if (says.empty()) continue;
      ++alarms;
      table.add({"right, without " + without, outcome.ended, says});
    }
  for (const Mistake& mistake : mistakes()) {
    if (mistake.name.find(arguments.only) == std::string::npos) continue;
    Input spoiled = right;
    mistake.make(spoiled);
    write(spoiled, mistake.keeps_sightings);
    files.images = arguments.images;
    if (mistake.photos) {
      write_photos(photos, right.scene, mistake.photos(right));
      files.images = photos;
    }
    const Outcome outcome = texture(arguments, files, "");
    const std::string says = news(outcome, normal);
    const std::string ended = says.empty() && outcome.ended == "textured" ? "SILENT" : outcome.ended;
    ++wrong;
    silent += ended == "SILENT" ? 1 : 0;
    table.add({mistake.name, ended, says});
    fmt::print(stderr, "{}: {}: {}\n", mistake.name, ended, says);
  }
  if (arguments.only.empty())
    for (const fs::path& file : {files.scene, files.mesh, photos}) fs::remove_all(file);
  const std::string text = fmt::format(
      "{}\n{} of {} wrong scenes were textured without a word; {} of {} random subsets of the right scene's "
      "views were warned of\n",
      table.markdown(), silent, wrong, alarms, runs);
  write_text(arguments.folder / "wrong_scenes.md", text);
  fmt::print("{}", text);
  return 0;
}

}  // namespace
}  // namespace gpvc

int main(int argc, char** argv) {
  CLI::App app(
      "What gpvc texture says of scenes that are wrong, each made from one that is right\n"
      "Photos are read where they are; a run of each of forty mistakes, and of random subsets of the views.");
  gpvc::Arguments arguments;
  std::error_code none;
  arguments.gpvc = std::filesystem::canonical("/proc/self/exe", none).parent_path().parent_path() / "app" / "gpvc";
  app.add_option("SCENE", arguments.scene, "A scene that is right")->required();
  app.add_option("MESH", arguments.mesh, "Its mesh")->required();
  app.add_option("--images", arguments.images, "Folder of the photos");
  app.add_option("-o", arguments.folder, "Folder for wrong_scenes.md and the scenes")->required();
  app.add_option("--subsets", arguments.subsets, "Random halves, thirds and quarters of the views, as many of each")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--only", arguments.only, "Mistakes whose names contain this; the last scene is left in the folder");
  app.add_option("--gpvc", arguments.gpvc, "The program to try")->capture_default_str();
  app.add_option("--option", arguments.options, "Given to gpvc texture, as --option=--downscale --option=2");
  return gpvc::run_benchmark(app, argc, argv, [&] { return gpvc::run(arguments); });
}
