// Spoils a scene that is right in the ways that scenes of users are wrong, textures each, and tells which of them the
// program refused, warned of or took without a word; and whether it warned of the right one, whole or with fewer views.
#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <numbers>
#include <random>
#include <set>
#include <utility>

#include "app/synth/synth_scene.h"
#include "benchmarks/child.h"
#include "benchmarks/command.h"
#include "benchmarks/table.h"
#include "io/mesh.h"
#include "io/scene_files.h"
#include "io/tie_points.h"
#include "io/vector.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path scene, mesh, images, folder, gpvc;
  int subsets = 3;
  std::vector<std::string> options;  ///< given to gpvc texture
};

struct Input {
  Scene scene;
  Mesh mesh;
};

/// One way to be wrong. Moves views among photos, or the mesh.
struct Mistake {
  std::string name;
  std::function<void(Input&)> make;
  /// Image lists say where photos show tie points, as they do until photos or poses are mixed up.
  bool keeps_sightings = false;
};

// --- mistakes of poses and lenses

void exchange_poses(Scene& scene, const std::vector<std::size_t>& from) {
  const std::vector<View> right = scene.views;
  for (std::size_t i = 0; i < from.size(); ++i) {
    scene.views[i].pose = right[from[i]].pose;
    scene.views[i].camera = right[from[i]].camera;
  }
}

/// Every photo gets another's pose.
std::vector<std::size_t> shuffled(std::size_t count) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  std::mt19937 random(1);
  // Sattolo 1986: one cycle through all, so that none stays in its place.
  for (std::size_t i = count - 1; i > 0; --i) std::swap(order[i], order[random() % i]);
  return order;
}

std::vector<std::size_t> rotated(std::size_t count, std::size_t by) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = (i + by) % count;
  return order;
}

std::vector<std::size_t> moved_by_one(std::size_t count) { return rotated(count, 1); }

std::vector<std::size_t> reversed(std::size_t count) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = count - 1 - i;
  return order;
}

std::vector<std::size_t> two_swapped(std::size_t count) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  std::swap(order[0], order[count / 2]);
  return order;
}

std::vector<std::size_t> pairs_exchanged(std::size_t count) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = std::min(i ^ 1, count - 1);
  return order;
}

/// About the optical axis: what a photo stored upside down comes to.
void turn_over(View& view) {
  for (std::size_t i = 0; i < 6; ++i) view.pose.rotation[i] = -view.pose.rotation[i];
}

/// Camera-to-world taken for world-to-camera.
void invert(Pose& pose) {
  const std::array<double, 9> r = pose.rotation;
  const WorldPoint c = pose.centre;
  pose.rotation = {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]};
  pose.centre = {-(r[0] * c.x + r[1] * c.y + r[2] * c.z), -(r[3] * c.x + r[4] * c.y + r[5] * c.z),
                 -(r[6] * c.x + r[7] * c.y + r[8] * c.z)};
}

Mistake of_order(const char* name, std::vector<std::size_t> (*order)(std::size_t)) {
  return {name, [order](Input& in) { exchange_poses(in.scene, order(in.scene.views.size())); }};
}

Mistake of_views(const char* name, void (*spoil)(View&)) {
  return {name, [spoil](Input& in) { std::ranges::for_each(in.scene.views, spoil); }};
}

Mistake of_lens(const char* name, void (*spoil)(Camera&)) {
  return {name,
          [spoil](Input& in) {
            for (View& view : in.scene.views) {
              spoil(view.camera);
              limit_distortion(view.camera);
            }
          },
          true};
}

// --- mistakes of meshes

struct Box {
  WorldPoint low, high;
  WorldPoint middle() const { return 0.5 * (low + high); }
  double extent() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
};

Box box_of(const Mesh& mesh) {
  Box box{mesh.positions[0], mesh.positions[0]};
  for (const WorldPoint& p : mesh.positions) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

/// `move` takes a position less the box's middle to what the mesh has instead.
Mistake about_middle(const char* name, WorldPoint (*move)(const WorldPoint& p, double extent),
                     bool turns_faces = false) {
  return {name,
          [=](Input& in) {
            const Box box = box_of(in.mesh);
            for (WorldPoint& p : in.mesh.positions) p = box.middle() + move(p - box.middle(), box.extent());
            if (turns_faces)
              for (Triangle& t : in.mesh.faces) std::swap(t[1], t[2]);
          },
          true};
}

Mistake about_origin(const char* name, WorldPoint (*move)(const WorldPoint& p)) {
  return {name, [=](Input& in) { std::ranges::transform(in.mesh.positions, in.mesh.positions.begin(), move); }, true};
}

WorldPoint turned_about_z(const WorldPoint& p, double degrees) {
  const double a = degrees * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a);
  return {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
}

WorldPoint turned_about_x(const WorldPoint& p, double degrees) {
  const double a = degrees * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a);
  return {p.x, c * p.y - s * p.z, s * p.y + c * p.z};
}

Mistake moved(const char* name, double x, double z) {
  return {name,
          [=](Input& in) {
            const double extent = box_of(in.mesh).extent();
            for (WorldPoint& p : in.mesh.positions) p = p + WorldPoint{x * extent, 0, z * extent};
          },
          true};
}

/// Every other view, as if two cameras had taken turns.
Mistake of_one_camera_of_two(const char* name, void (*spoil)(Camera&)) {
  return {name,
          [spoil](Input& in) {
            for (std::size_t v = 0; v < in.scene.views.size(); v += 2) {
              spoil(in.scene.views[v].camera);
              limit_distortion(in.scene.views[v].camera);
            }
          },
          true};
}

std::vector<Mistake> mistakes_of_views() {
  return {
      of_order("photos in random order", shuffled),
      of_order("photos in reverse order", reversed),
      of_order("photos moved by one", moved_by_one),
      of_order("two photos swapped", two_swapped),
      {"one photo turned by 180 degrees", [](Input& in) { turn_over(in.scene.views[in.scene.views.size() / 2]); }},
      of_views("all photos turned by 180 degrees", turn_over),
      {"all cameras at one pose",
       [](Input& in) {
         for (View& view : in.scene.views) view.pose = in.scene.views[0].pose;
       }},
      of_views("poses inverted", [](View& view) { invert(view.pose); }),
      of_lens("k1 = -5", [](Camera& c) { c.distortion.k1 = -5; }),
      of_lens("focal length a fifth too long", [](Camera& c) { c.fx *= 1.2, c.fy *= 1.2; }),
      of_lens("focal length of photos twice as large", [](Camera& c) { c.fx *= 2, c.fy *= 2; }),
      of_order("photos moved by two", [](std::size_t count) { return rotated(count, 2); }),
      of_order("photos exchanged in pairs", pairs_exchanged),
      {"one pose 2 % of the mesh's size to the side",
       [](Input& in) { in.scene.views[in.scene.views.size() / 2].pose.centre.x += 0.02 * box_of(in.mesh).extent(); }},
      of_views("cameras' y and z axes turned round",
               [](View& view) {
                 for (std::size_t i = 3; i < 9; ++i) view.pose.rotation[i] = -view.pose.rotation[i];
               }),
      of_views("all photos turned by 90 degrees",
               [](View& view) {
                 auto& r = view.pose.rotation;
                 for (std::size_t i = 0; i < 3; ++i) r[i] = -std::exchange(r[i + 3], r[i]);
               }),
      of_lens("focal length of photos half as large", [](Camera& c) { c.fx *= 0.5, c.fy *= 0.5; }),
      of_lens("focal length 5 % too long", [](Camera& c) { c.fx *= 1.05, c.fy *= 1.05; }),
      of_lens("pixels 5 % higher than wide", [](Camera& c) { c.fy *= 1.05; }),
      of_lens("principal point 1 % of the width to the right", [](Camera& c) { c.cx += 0.01 * c.width; }),
      of_lens("principal point 3 % of the width lower", [](Camera& c) { c.cy += 0.03 * c.width; }),
      of_one_camera_of_two("one camera of two with another focal length", [](Camera& c) { c.fx *= 1.2, c.fy *= 1.2; }),
      of_one_camera_of_two("one camera of two with the principal point 2 % of the width to the left",
                           [](Camera& c) { c.cx -= 0.02 * c.width; }),
  };
}

std::vector<Mistake> mistakes_of_meshes() {
  using P = WorldPoint;
  return {
      about_middle("mesh 5 % of its size to the side",
                   [](const P& p, double e) {
                     return p + P{0.05 * e, 0, 0};
                   }),
      about_middle("mesh 5 % of its size higher",
                   [](const P& p, double e) {
                     return p + P{0, 0, 0.05 * e};
                   }),
      about_middle("mesh 1.05 times as large, about its middle", [](const P& p, double) { return 1.05 * p; }),
      about_middle("mesh turned by 10 degrees about z", [](const P& p, double) { return turned_about_z(p, 10); }),
      about_middle("mesh turned by 10 degrees about x", [](const P& p, double) { return turned_about_x(p, 10); }),
      about_middle(
          "mesh mirrored",
          [](const P& p, double) {
            return P{-p.x, p.y, p.z};
          },
          true),
      about_origin("mesh 1.05 times as large, about the origin", [](const P& p) { return 1.05 * p; }),
      about_origin("mesh in feet", [](const P& p) { return (1 / 0.3048) * p; }),
      about_origin("mesh's y and z exchanged",
                   [](const P& p) {
                     return P{p.x, -p.z, p.y};
                   }),
      about_origin("mesh a millionth as large", [](const P& p) { return 1e-6 * p; }),
      moved("mesh 2 % of its size to the side", 0.02, 0),
      moved("mesh 20 % of its size to the side", 0.2, 0),
      moved("mesh half its size lower, as heights above the geoid are", 0, -0.5),
      about_middle("mesh 0.9 times as large, about its middle", [](const P& p, double) { return 0.9 * p; }),
      about_middle("mesh turned by 180 degrees about z", [](const P& p, double) { return turned_about_z(p, 180); }),
      about_middle(
          "mesh upside down",
          [](const P& p, double) {
            return P{p.x, p.y, -p.z};
          },
          true),
      about_origin("mesh in millimetres", [](const P& p) { return 1000.0 * p; }),
  };
}

std::vector<Mistake> mistakes() {
  std::vector<Mistake> all = mistakes_of_views();
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
      const View& view = right.views[index(id)];
      const CameraPoint c = camera_from_world(view.pose, points[n].position);
      if (!(c.z > 0)) continue;
      const auto at = photo_from_pixel(view.camera, pixel_from_camera(view.camera, c));
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
  std::vector<ViewId> all;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) all.push_back(ViewId{v});
  const auto places = io::photo_places(io::SceneTarget::colmap, scene, all);
  io::write_scene(io::SceneTarget::colmap, scene, all, places, folder);
  write_points(folder / "sparse" / "points3D.bin", points);
}

// --- runs

struct Outcome {
  std::string ended;           ///< "refused", "textured"
  std::set<std::string> says;  ///< warnings and errors
};

Outcome texture(const Arguments& arguments, const fs::path& scene, const fs::path& mesh, const std::string& without) {
  const fs::path model = arguments.folder / "model", log = arguments.folder / "log.txt";
  std::vector<std::string> words{
      arguments.gpvc.string(), "texture", scene.string(), mesh.string(), "--images", arguments.images.string(), "-o",
      model.string(),          "--force", "--quiet",      "--no-resume"};
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
  const fs::path model = arguments.folder / "scene", mesh = arguments.folder / "mesh.ply";

  Table table({"scene", "ended", "says"});
  const auto add = [&](const std::string& name, const Outcome& outcome, const std::string& says) {
    table.add({name, says.empty() && outcome.ended == "textured" ? "SILENT" : outcome.ended, says});
    fmt::print(stderr, "{}: {}: {}\n", name, outcome.ended, says);
  };
  write_model(model, right.scene, points);
  add_sightings(model / "sparse" / "images.bin", right.scene, points);
  synth::write_synth_mesh(mesh, right.mesh, {});
  const Outcome normal = texture(arguments, model, mesh, "");
  table.add({"right", normal.ended, news(normal, {})});
  std::mt19937 random(7);
  std::size_t runs = 0, alarms = 0;
  for (const std::size_t share : {2, 3, 4})
    for (int n = 0; n < arguments.subsets; ++n) {
      const std::string without = random_rest(right.scene, share, random);
      const Outcome outcome = texture(arguments, model, mesh, without);
      ++runs;
      const std::string says = news(outcome, normal);
      if (says.empty()) continue;
      ++alarms;
      add("right, without " + without, outcome, says);
    }
  for (const Mistake& mistake : mistakes()) {
    Input wrong = right;
    mistake.make(wrong);
    write_model(model, wrong.scene, points);
    if (mistake.keeps_sightings) add_sightings(model / "sparse" / "images.bin", right.scene, points);
    synth::write_synth_mesh(mesh, wrong.mesh, {});
    const Outcome outcome = texture(arguments, model, mesh, "");
    add(mistake.name, outcome, news(outcome, normal));
  }
  fs::remove_all(model);
  fs::remove(mesh);
  const std::string text = fmt::format("{}\n{} of {} random subsets of the right scene's views were warned of\n",
                                       table.markdown(), alarms, runs);
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
  app.add_option("--gpvc", arguments.gpvc, "The program to try")->capture_default_str();
  app.add_option("--option", arguments.options, "Given to gpvc texture, as --option=--downscale --option=2");
  return gpvc::run_benchmark(app, argc, argv, [&] { return gpvc::run(arguments); });
}
