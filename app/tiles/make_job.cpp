#include "app/tiles/make_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>

#include "app/checks/coarse_depths.h"
#include "app/checks/frame_check.h"
#include "app/checks/tie_point_fit.h"
#include "app/pipeline/texture_files.h"
#include "app/tiles/done.h"
#include "app/tiles/plan_text.h"
#include "app/tiles/tile_work.h"
#include "app/tileset/placing.h"
#include "app/tileset/tile_files.h"
#include "app/tileset/tile_tree.h"
#include "io/output_file.h"
#include "io/photos.h"
#include "io/vector.h"

namespace gpvc::tiles {
namespace {

// Per tile, the share of its faces in views' frames, seen from the front, that nothing hides: from a coarse look of some views.
// In a park it is 0.9, in a city under oblique photos 0.4.
std::vector<double> unhidden_shares(const checks::Input& input, std::span<const std::uint32_t> tile,
                                    std::size_t tiles) {
  using checks::CoarseDepths;
  constexpr std::size_t kViews = 12, kFaces = 20000;
  // Depths of a cell vary by as much on a slope.
  constexpr double kWithin = 1.03;
  const std::size_t view_stride = input.views.size() / kViews + 1, face_stride = input.mesh.faces.size() / kFaces + 1;
  const checks::FaceRuns runs(input.mesh);
  std::vector<double> framed(tiles + 1, 0.0), seen(tiles + 1, 0.0);  // the last: of all tiles
  for (std::size_t n = 0; n < input.views.size(); n += view_stride) {
    const View& view = input.scene.views[index(input.views[n])];
    const CoarseDepths coarse = checks::draw_coarse_depths(input.mesh, runs, view);
    for (std::size_t f = 0; f < input.mesh.faces.size(); f += face_stride) {
      std::array<WorldPoint, 3> p;
      for (std::size_t i = 0; i < 3; ++i) p[i] = input.mesh.positions[input.mesh.faces[f][i]];
      const WorldPoint middle = (p[0] + p[1] + p[2]) * (1.0 / 3);
      if (dot(cross(p[1] - p[0], p[2] - p[0]), middle - view.pose.centre) >= 0) continue;
      const CameraPoint c = camera_from_world(view.pose, middle);
      if (!(c.z > 0)) continue;
      const PixelPoint q = pixel_from_camera(view.camera, c);
      if (!(q.x >= 0 && q.y >= 0 && q.x < view.camera.width && q.y < view.camera.height)) continue;
      const auto column = static_cast<std::size_t>(q.x * CoarseDepths::kColumns / view.camera.width);
      const auto row = static_cast<std::size_t>(q.y * CoarseDepths::kRows / view.camera.height);
      const bool unhidden = c.z <= kWithin * double{coarse.depths[row * CoarseDepths::kColumns + column]};
      for (const std::size_t t : {std::size_t{tile[f]}, tiles}) {
        framed[t] += 1;
        seen[t] += unhidden ? 1 : 0;
      }
    }
  }
  // Known to a few per cent from so many; of tiles with fewer, what is known of all.
  constexpr double kLeast = 200;
  std::vector<double> shares;
  for (std::size_t t = 0; t < tiles; ++t) {
    const std::size_t from = framed[t] < kLeast ? tiles : t;
    shares.push_back(framed[from] > 0 ? seen[from] / framed[from] : 1);
  }
  return shares;
}

TileInfo tile_info(const pipeline::Input& input, const pipeline::Settings& settings, const TileMesh& tile,
                   std::uint32_t number) {
  TileInfo info;
  if (tile.face.empty()) return info;
  for (const WorldPoint& p : tile.mesh.positions) info.box.add(p);
  const std::vector<std::uint32_t> own = tile.own(number);
  for (const std::uint32_t f : own)
    for (const std::uint32_t v : tile.mesh.faces[f]) info.own_box.add(tile.mesh.positions[v]);
  info.faces = own.size();
  info.all_faces = tile.face.size();
  info.vertices = tile.vertex.size();
  info.around = tile.tile;
  std::ranges::sort(info.around);
  info.around.erase(std::unique(info.around.begin(), info.around.end()), info.around.end());
  std::erase(info.around, number);
  const auto hull = checks::corners(info.box);
  for (const ViewId view : input.views)
    if (checks::hull_may_be_framed(input.scene.views[index(view)], hull)) info.views.push_back(view);
  const pipeline::Workload work = pipeline::workload({input.scene, tile.mesh, info.views, input.mesh_file}, settings);
  info.pairs = work.pairs;
  info.texels = work.texels;
  return info;
}

void add_parents(std::span<const std::uint32_t> children, std::uint32_t self, std::vector<std::uint32_t>& parents) {
  for (const std::uint32_t child : children)
    if (child / 4 != self) parents.push_back(child / 4);
  std::ranges::sort(parents);
  parents.erase(std::unique(parents.begin(), parents.end()), parents.end());
}

void add_box(const checks::Box& box, checks::Box& all) {
  for (const WorldPoint& corner : checks::corners(box)) all.add(corner);
}

// What is known of it before its tiles are made: a quarter of the faces, whose vertices are among those of the level below.
Level level_above(const Level& below) {
  Level level;
  for (std::uint32_t t = 0; t < below.tiles.size() / 4; ++t) {
    TileInfo& tile = level.tiles.emplace_back();
    for (std::uint32_t child = 4 * t; child < 4 * t + 4; ++child) {
      const TileInfo& part = below.tiles[child];
      if (part.faces > 0) add_box(part.own_box, tile.own_box);
      tile.faces += part.faces;
      tile.vertices += part.vertices;
      tile.pairs += part.pairs;
      tile.texels += part.texels;
      add_parents(part.beside, t, tile.beside);
      add_parents(part.around, t, tile.around);
    }
    tile.faces /= 4;
    tile.vertices /= 4;
    // The border is as many edges wide as on the level below, around four times the ground.
    for (std::uint32_t child = 4 * t; child < 4 * t + 4; ++child) tile.all_faces += below.tiles[child].all_faces / 4;
    tile.pairs /= 4;
    tile.texels /= 4;
  }
  // Of a tile and those around it, in whose boxes its border lies.
  for (std::uint32_t t = 0; t < level.tiles.size(); ++t) {
    TileInfo& tile = level.tiles[t];
    std::vector<std::uint32_t> all = tile.around;
    all.push_back(t);
    for (const std::uint32_t part : all)
      for (std::uint32_t child = 4 * part; child < 4 * part + 4; ++child) {
        const TileInfo& piece = below.tiles[child];
        if (piece.faces > 0) add_box(piece.box, tile.box);
        tile.views.insert(tile.views.end(), piece.views.begin(), piece.views.end());
      }
    std::ranges::sort(tile.views);
    tile.views.erase(std::unique(tile.views.begin(), tile.views.end()), tile.views.end());
  }
  color_tiles(level.tiles);
  return level;
}

// Photos of a level are reduced as its texels are larger, as long as something is left of the smallest one. Panoramas are not:
// both of their sides must meet.
int reduction_for(const checks::Input& input, int level) {
  constexpr int kLeastEdge = 64;
  int least = std::numeric_limits<int>::max();
  for (const ViewId id : input.views) {
    const Camera& camera = input.scene.views[index(id)].camera;
    if (is_spherical(camera.distortion.model)) return 1;
    least = std::min({least, camera.width, camera.height});
  }
  int reduction = 1;
  while (level-- > 0 && least / (2 * reduction) >= kLeastEdge) reduction *= 2;
  return reduction;
}

// Cuts the tiles; hands each to `take`.
void cut(const checks::Input& input, const JobSettings& settings, results::Observer& observer,
         const std::function<void(std::uint32_t, const TileMesh&)>& take, Job& job) {
  observer.begin({"cut", "tiles"});
  const std::size_t leaves = tileset::leaf_count(input.mesh.faces.size(), settings.tiles.faces_per_tile);
  const int depth = tileset::tree_depth(leaves);
  const std::size_t tiles = std::size_t{1} << (2 * depth);
  const io::UpAxis up = settings.texture.output.up.value_or(pipeline::scene_up(input.scene, input.views));
  const std::vector<std::uint32_t> leaf = tileset::leaf_of_faces(input.mesh, up, leaves);
  TileCutter cutter(input.mesh, leaf, tiles);
  Level finest;
  finest.texel_size = settings.texture.atlas.texel_size;
  job.views.assign(input.views.begin(), input.views.end());
  job.mesh_file = input.mesh_file;
  job.settings = settings;
  for (std::uint32_t t = 0; t < tiles; ++t) {
    observer.progress(t, tiles);
    const TileMesh tile = cutter.cut(t);
    if (take) take(t, tile);
    finest.tiles.push_back(tile_info(input, settings.texture, tile, t));
    finest.tiles.back().beside = cutter.beside(t);
  }
  const std::vector<double> unhidden = unhidden_shares(input, leaf, tiles);
  for (std::size_t t = 0; t < tiles; ++t) finest.tiles[t].pairs *= unhidden[t];
  color_tiles(finest.tiles);
  job.groups = group_views(input.scene, input.views, settings.views_per_unit);
  // Units run in other folders, and on other machines.
  job.scene.source = input.scene.source;
  job.scene.srs = input.scene.srs;
  job.scene.offset = input.scene.offset;
  job.scene.views = input.scene.views;
  job.scene.bands = input.scene.bands;
  job.scene.band_places = input.scene.band_places;
  for (View& view : job.scene.views) {
    std::vector<fs::path*> files{&view.photo, &view.mask};
    for (fs::path& file : view.band_files) files.push_back(&file);
    for (fs::path* file : files)
      if (!file->empty()) *file = fs::absolute(*file).lexically_normal();
  }
  job.scene.circle_photos = input.scene.circle_photos;
  for (HashedPhoto& photo : job.scene.circle_photos) photo.file = fs::absolute(photo.file).lexically_normal();
  job.levels.push_back(std::move(finest));
  const std::vector<double> lengths = checks::sampling_distances(input.mesh, input.scene, input.views);
  const double photo_texel = lengths.empty() ? 0 : lengths[lengths.size() / 2];
  for (int k = 1; k <= depth && settings.levels; ++k) {
    Level level = level_above(job.levels.back());
    level.texel_size = std::ldexp(std::max(photo_texel, job.levels[0].texel_size), k);
    level.reduction = reduction_for(input, k);
    job.levels.push_back(std::move(level));
  }
  observer.end(fmt::format("{} tiles, {} groups of views", leaves, job.groups.size()));
}

}  // namespace

Job cut_scene(const checks::Input& input, const JobSettings& settings, results::Observer& observer) {
  Job job;
  cut(input, settings, observer, {}, job);
  return job;
}

std::vector<Unit> make_job(const JobFolder& folder, const pipeline::Input& input, const JobSettings& settings,
                           const std::string& program, pipeline::Observer& observer) {
  checks::validate(input);
  pipeline::check_band_format(input, settings.texture.output);
  tileset::refuse_place(input.scene, input.mesh.positions.front(), settings.tiles.place);
  // Whose bytes count are those that units look at.
  io::CallbackSource no_photos(input.scene, [](ViewId) { return io::Picture{}; });
  const pipeline::Run run{input, settings.texture, no_photos, observer};
  Job job;
  job.settings = settings;
  // Which faces have a view is not known yet.
  const std::vector<ViewId> any(input.mesh.faces.size(), input.views.front());
  job.model = pipeline::model_options(input, any, settings.texture.output);
  job.tiles_model = pipeline::model_options(input, any, settings.texture.output, pipeline::Coordinates::of_scene);
  // They would differ along the borders of tiles.
  job.model.normals = job.tiles_model.normals = false;
  job.tiles_model.copyright = settings.tiles.copyright;
  job.tiles_model.coding = tileset::tile_coding(settings.texture.output, settings.tiles.compress);
  job.color_profile = pipeline::profile_of_photos(run);
  job.tie_points = checks::read_tie_points(input.scene, observer);
  job.listed = pipeline::listed_vertices(settings.texture.view_rules, input.mesh);
  pipeline::allowed_views(settings.texture.view_rules, input.mesh, input.scene.views.size(), observer);  // notes them
  const io::WorkKey key = job_key(run, program, job);
  const fs::path mesh = folder.path() / "mesh";
  Done files{key};
  const auto keep_tile = [&](std::uint32_t number, const TileMesh& tile) {
    folder.keep(mesh, tile_file(number), key, [&](io::WorkStore::Writer& out) { out.add(tile); });
    files.outputs.push_back(output_of(folder.path(), mesh / tile_file(number)));
  };
  cut(input, settings, observer, keep_tile, job);
  folder.write_job(job, key);
  files.outputs.push_back(output_of(folder.path(), mesh / kSceneFile));
  write_done(folder.mesh_files(), files);
  std::vector<Unit> units = plan_units(job);
  io::write_file(folder.path() / "plan.json", plan_text(units, program));
  // What units of another job in this folder have left would lie among the tiles of this one. Before its key is there, or a
  // run that is killed in between would never remove it.
  if (folder.key_if_made() != key) folder.remove_units();
  write_done(mesh / "done.json", {key});
  return units;
}

}  // namespace gpvc::tiles
