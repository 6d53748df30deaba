// How much background a texture has: photos whose objects are cut out on one colour, or that have black borders, or for which
// masks say where their background is.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "app/checks/scene_fit.h"
#include "app/pipeline/pipeline.h"
#include "benchmarks/command.h"
#include "benchmarks/table.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/scene_files.h"
#include "visibility/visibility.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path scene, mesh, folder;
  std::optional<fs::path> images, masks;
  int downscale = 1;
  int cut = 0, border = 0;
  double noise = 3;
  std::vector<int> color{0, 0, 0};
};

/// Of a photo, a byte for each pixel: 1 where it shows background.
using Shown = std::vector<std::uint8_t>;

/// Everything that is no face's in the frame, or less than `cut` pixels away from that.
Shown cut_out(const View& view, const visibility::Ivm& ivm, int cut) {
  const int width = ivm.width, height = ivm.height;
  Shown bare(ivm.faces.size()), wide(bare.size()), shown(bare.size(), 1);
  for (std::size_t i = 0; i < bare.size(); ++i) bare[i] = ivm.faces[i] == kNoFace ? 1 : 0;
  const auto widen = [&](const Shown& from, Shown& to, int dx, int dy) {
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x) {
        std::uint8_t any = 0;
        for (int step = -cut; step <= cut && any == 0; ++step) {
          const int px = x + step * dx, py = y + step * dy;
          if (px >= 0 && py >= 0 && px < width && py < height) any = from[pixel_index(px, py, width)];
        }
        to[pixel_index(x, y, width)] = any;
      }
    });
  };
  widen(bare, wide, 1, 0);
  widen(wide, bare, 0, 1);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const auto at = pixel_from_photo(view.camera, {x + 0.5, y + 0.5});
      if (!at || !(at->x >= 0 && at->y >= 0 && at->x < width && at->y < height)) continue;
      shown[pixel_index(x, y, width)] = bare[pixel_index(static_cast<int>(at->x), static_cast<int>(at->y), width)];
    }
  });
  return shown;
}

/// A border whose inner edge is bent, as undistortion leaves it: widest in the corners.
void add_border(const Camera& camera, int border, Shown& shown) {
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const double u = std::abs(2 * (x + 0.5) / camera.width - 1), v = std::abs(2 * (y + 0.5) / camera.height - 1);
      const double from_edge = std::min((1 - u) * camera.width, (1 - v) * camera.height) / 2;
      if (from_edge < border * (0.3 + 0.7 * std::min(u, v))) shown[pixel_index(x, y, camera.width)] = 1;
    }
}

Shown of_mask(const View& view, const fs::path& folder) {
  const Image mask = io::read_image(folder / (view.name + ".png"));
  if (mask.width != view.camera.width || mask.height != view.camera.height)
    throw std::runtime_error(
        fmt::format("{}: the mask of {} has another size than its photo", folder.string(), view.name));
  Shown shown;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) shown.push_back(mask.at(x, y)[0] >= 128 ? 1 : 0);
  return shown;
}

/// Writes the photo with its background in one colour, with noise, as a JPEG file.
void paint(const fs::path& file, Image photo, const Shown& shown, const Arguments& arguments) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, arguments.noise);
  for (std::size_t i = 0; i < shown.size(); ++i)
    for (std::size_t c = 0; shown[i] != 0 && c < 3; ++c)
      photo.pixels[3 * i + c] = static_cast<std::uint8_t>(std::clamp(arguments.color[c] + noise(random), 0.0, 255.0));
  fs::create_directories(file.parent_path());
  io::write_image(file, photo, io::ImageFormat::jpg, 92);
}

/// Sums of areas, in pixels of the photos.
struct Areas {
  double textured = 0, background = 0;
};

/// Of the points that photos texture, those whose place in the photo shows background. Some points a pixel.
Areas measure(const atlas::TextureOrigins& origins, const Mesh& mesh, const Scene& scene,
              std::span<const ViewId> labels, std::span<const Shown> shown) {
  Areas areas;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (labels[f] == kNoView) continue;
    const View& view = scene.views[index(labels[f])];
    std::array<std::optional<PixelPoint>, 3> at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = pixel_from_world(view, mesh.positions[mesh.faces[f][k]]);
    if (!at[0] || !at[1] || !at[2]) continue;
    const double area =
        std::abs((at[1]->x - at[0]->x) * (at[2]->y - at[0]->y) - (at[2]->x - at[0]->x) * (at[1]->y - at[0]->y)) / 2;
    const int steps = std::clamp(static_cast<int>(std::ceil(std::sqrt(2 * area))), 1, 64);
    const double part = area / (static_cast<double>(steps) * (steps + 1) / 2);
    for (int i = 0; i < steps; ++i)
      for (int j = 0; i + j < steps; ++j) {
        const auto origin = origins.at(FaceId{f}, (i + 1.0 / 3) / steps, (j + 1.0 / 3) / steps);
        if (origin.first == kNoView) continue;
        const Camera& camera = scene.views[index(origin.first)].camera;
        const auto photo = photo_from_pixel(camera, origin.first_at);
        if (!photo) continue;
        const int x = std::clamp(static_cast<int>(photo->x), 0, camera.width - 1);
        const int y = std::clamp(static_cast<int>(photo->y), 0, camera.height - 1);
        areas.textured += part;
        if (shown[index(origin.first)][pixel_index(x, y, camera.width)] != 0) areas.background += part;
      }
  }
  return areas;
}

int run(const Arguments& arguments) {
  io::SceneOptions options;
  options.images_dir = arguments.images;
  options.downscale = arguments.downscale;
  options.masks = false;
  Scene scene = io::read_scene(arguments.scene, options);
  Mesh mesh = io::read_mesh(arguments.mesh);
  results::Observer silent;
  const std::vector<ViewId> views = all_views(scene);
  checks::prepare(scene, mesh, views, {arguments.mesh}, silent);
  std::vector<Shown> shown(scene.views.size());
  std::vector<io::Picture> pictures(scene.views.size());
  {
    io::PhotoCache photos(scene);
    visibility::VisibilityStage stage(mesh, {.method = visibility::Gpvc{.drawing = visibility::Drawing::native}});
    for (const ViewId id : views) {
      const View& view = scene.views[index(id)];
      Shown& here = shown[index(id)];
      const Image photo = *photos.photo(id);
      here = arguments.masks     ? of_mask(view, *arguments.masks)
             : arguments.cut > 0 ? cut_out(view, stage.classify(view, id, nullptr).ivm, arguments.cut)
                                 : Shown(pixel_index(0, view.camera.height, view.camera.width), 0);
      if (arguments.border > 0) add_border(view.camera, arguments.border, here);
      const fs::path file = arguments.folder / "photos" / fs::path(view.name).replace_extension(".jpg");
      if (arguments.masks) {
        pictures[index(id)] = {photo, {}};
      } else {
        paint(file, photo, here, arguments);
        pictures[index(id)] = {io::read_image(file), {}};
      }
    }
  }
  io::PictureSource photos(scene, pictures);
  Table table({"background", "textured, MP", "of it background, %", "faces seen", "in its place", "filled"});
  for (const auto& [name, background] : labeling::kBackgroundNames) {
    pipeline::Settings settings;
    settings.costs.background = background;
    settings.allow_misfit = settings.allow_unseen = settings.costs.keep_odd_views = true;
    const pipeline::Input input{scene, mesh, views};
    const labeling::FaceGraph graph = pipeline::weighed_graph(mesh, settings.edge_weights, silent);
    const pipeline::Seen seen = pipeline::see({input, settings, photos, silent}, {.graph = &graph});
    const labeling::Selection selection = pipeline::choose(seen.candidates.table, graph, settings.solver, silent);
    const atlas::AtlasInput from = pipeline::atlas_input(input, photos, graph, seen, selection.labels);
    const atlas::AtlasPlan plan = atlas::plan_atlas(from, settings.atlas);
    const Areas areas = measure(atlas::TextureOrigins(plan, from), mesh, scene, selection.labels, shown);
    const auto counts = checks::count_tags(seen.candidates.tags);
    table.add({name, fmt::format("{:.2f}", areas.textured / 1e6),
               fmt::format("{:.3f}", 100 * areas.background / std::max(areas.textured, 1.0)),
               fmt::to_string(counts[0] + counts[1]), fmt::to_string(counts[3]), fmt::to_string(counts[2])});
  }
  fmt::print("{}", table.markdown());
  return 0;
}

}  // namespace
}  // namespace gpvc

int main(int argc, char** argv) {
  CLI::App app(
      "How much background a texture has, with and without gpvc texture's --background auto\n"
      "Photos are cut out along the mesh's silhouettes, get borders, or come with masks of their background.");
  gpvc::Arguments arguments;
  app.add_option("SCENE", arguments.scene, "Cameras and photos")->required();
  app.add_option("MESH", arguments.mesh, "Triangle mesh")->required();
  app.add_option("--images", arguments.images, "Folder of the photos");
  app.add_option("--downscale", arguments.downscale, "Reduce the photos")->check(CLI::Range(1, 64));
  app.add_option("--cut", arguments.cut, "Paint all but the mesh, and so many pixels of it along its silhouettes")
      ->check(CLI::Range(1, 1000));
  app.add_option("--border", arguments.border, "Paint a border, so many pixels wide in its corners")
      ->check(CLI::Range(1, 1000));
  app.add_option("--color", arguments.color, "R G B of what is painted")->expected(3)->check(CLI::Range(0, 255));
  app.add_option("--noise", arguments.noise, "Standard deviation of its grey levels")->capture_default_str();
  app.add_option("--masks", arguments.masks, "Paint nothing: folder of masks, NAME.EXT.png, white where background is")
      ->check(CLI::ExistingDirectory);
  app.add_option("-o", arguments.folder, "Folder for the photos that are painted")->required();
  return gpvc::run_benchmark(app, argc, argv, [&] { return gpvc::run(arguments); });
}
