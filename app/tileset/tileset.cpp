#include "app/tileset/tileset.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "app/checks/frame_check.h"
#include "app/pipeline/memory.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/texture_files.h"
#include "app/tileset/compressed_glb.h"
#include "app/tileset/tile_model.h"
#include "app/tileset/tile_tree.h"
#include "app/tileset/tileset_json.h"
#include "io/freed_memory.h"
#include "io/grouping.h"
#include "io/images.h"
#include "io/output_file.h"

namespace gpvc::tileset {
namespace {

namespace fs = std::filesystem;

// The pages of a level while its tiles are not written: files in the folder that is in making.
class PageFiles {
 public:
  PageFiles(const fs::path& folder, std::size_t pages, const pipeline::OutputSettings& output, io::ColorProfile profile)
      : output_(output), profile_(std::move(profile)) {
    for (std::size_t p = 0; p < pages; ++p)
      files_.push_back({folder / ("page-" + pipeline::page_name(p, output.texture)), output.texture});
  }
  ~PageFiles() {
    std::error_code ignored;
    for (const io::PageFile& page : files_) fs::remove(page.file, ignored);
  }
  PageFiles(const PageFiles&) = delete;
  PageFiles& operator=(const PageFiles&) = delete;

  void write(std::size_t number, const Image& page) const {
    io::write_image(files_[number].file, page, output_.texture, output_.quality, profile_);
  }
  std::span<const io::PageFile> files() const { return files_; }

 private:
  const pipeline::OutputSettings& output_;
  io::ColorProfile profile_;
  std::vector<io::PageFile> files_;
};

// A level with what it is textured with.
struct Level {
  const Mesh& mesh;
  std::span<const std::uint32_t> tile;  ///< per face
  std::span<const double> error;        ///< per tile, of its surface
  int number = 0;                       ///< 0: the leaves
  double texel_size = 0;
};

class TilesetMaker {
 public:
  TilesetMaker(const checks::Input& input, const TilesetSettings& settings, io::PhotoSource& photos,
               results::OutputFolder& folder, results::Observer& observer)
      : input_(input),
        settings_(settings),
        photos_(photos),
        folder_(folder),
        observer_(observer),
        views_(input.views.begin(), input.views.end()),
        profile_(pipeline::profile_of_photos(input, observer)) {}

  TilesetReport make() {
    const int depth = tree_depth(input_.mesh.faces.size(), settings_.faces_per_tile);
    const io::UpAxis up = pipeline::scene_up(input_.scene, input_.views);
    const std::vector<std::uint32_t> leaf = leaf_of_faces(input_.mesh, up, depth);
    const double photo_texel = median_pixel();
    std::vector<double> exact(std::size_t{1} << (2 * depth), 0.0);
    Level level{input_.mesh, leaf, exact, 0, settings_.texture.atlas.texel_size};
    make_level(level, depth);
    LevelMesh above;
    for (int k = 1; k <= depth; ++k) {
      above = k == 1 ? coarser_level(input_.mesh, leaf, exact) : coarser_level(above.mesh, above.tile, above.error);
      const double finest = std::max(photo_texel, settings_.texture.atlas.texel_size);
      make_level({above.mesh, above.tile, above.error, k, std::ldexp(finest, k)}, depth);
    }
    io::OutputFile file(folder_.file("tileset.json"));
    file.write(tileset_text(tiles_, options_));
    file.commit();
    report_.georeferenced = geocentric_from_tile(options_).has_value();
    return std::move(report_);
  }

 private:
  // The length that a pixel covers on the mesh.
  double median_pixel() const {
    const std::vector<double> lengths = checks::sampling_distances(input_.mesh, input_.scene, input_.views);
    return lengths.empty() ? 0 : lengths[lengths.size() / 2];
  }

  void make_level(const Level& level, int depth) {
    if (depth > 0)
      observer_.note(
          fmt::format("level {} of {}: {} faces in {} tiles{}", level.number, depth,
                      results::readable_count(level.mesh.faces.size()), level.error.size(),
                      level.number > 0 ? fmt::format(", texels of {:.3g} units or more", level.texel_size) : ""));
    pipeline::Settings settings = settings_.texture;
    settings.atlas.texel_size = level.texel_size;
    if (level.number > 0)
      settings.costs.keep_views = settings.allow_unseen = true;  // level 0 has judged photos and mesh
    const checks::Input input{input_.scene, level.mesh, views_, input_.mesh_file};
    const pipeline::MemoryPlan memory = pipeline::plan_memory(input, settings);
    if (level.number == 0) {
      // Each level takes a quarter of the one below: a third more together.
      const pipeline::FileSizes sizes = pipeline::predicted_sizes(input, settings, memory.work.texels);
      folder_.expect_space(sizes.least, sizes.likely * 4 / 3, observer_);
    }
    pipeline::Choice chosen = pipeline::see_and_choose(input, settings, memory, photos_, observer_);
    if (level.number == 0) {
      options_ =
          pipeline::model_options(input, chosen.selection.labels, settings.output, pipeline::Coordinates::of_scene);
      options_.normals = false;  // they would differ along the borders of tiles
      keep_used_views(chosen.selection.labels);
    }
    atlas::AtlasInput from = pipeline::atlas_input(input, photos_, chosen.graph, chosen.seen, chosen.selection.labels);
    from.tile = level.tile;
    observer_.begin({"atlas", "steps"});
    const atlas::AtlasPlan plan = pipeline::plan_and_note(from, settings.atlas, observer_);
    const PageFiles pages(folder_.in_making(), plan.estimate().pages, settings.output, profile_);
    atlas::BakeOptions bake = pipeline::bake_options(plan, settings, memory, photos_);
    bake.scratch_folder = folder_.in_making();
    bake.take_page = [&](std::size_t number, const Image& page) {
      observer_.check_cancelled();
      pages.write(number, page);
    };
    const atlas::TextureAtlas atlas = pipeline::bake_and_end(plan, from, settings.atlas, observer_, bake);
    write_tiles(level, atlas, chosen.seen.candidates.tags, pages);
    release_freed_memory();
  }

  void keep_used_views(std::span<const ViewId> labels) {
    std::vector<std::uint8_t> used(input_.scene.views.size(), 0);
    for (const ViewId label : labels)
      if (label != kNoView) used[index(label)] = 1;
    std::erase_if(views_, [&](ViewId view) { return used[index(view)] == 0; });
  }

  void write_tiles(const Level& level, const atlas::TextureAtlas& atlas, std::span<const labeling::FaceTag> tags,
                   const PageFiles& pages) {
    observer_.begin({"write"});
    const std::size_t count = level.error.size();
    const Grouped<std::uint32_t> faces = group_items<std::uint32_t>(count, [&](const auto& add) {
      for (std::uint32_t f = 0; f < level.tile.size(); ++f) add(level.tile[f], f);
    });
    std::vector<Tile>& tiles = tiles_.emplace_back(count);
    std::vector<fs::path> stems(count);
    for (std::size_t t = 0; t < count; ++t) {
      if (faces[t].empty()) continue;
      tiles[t].file = fmt::format("tiles/{}_{}.glb", level.number, t);
      stems[t] = folder_.file(tiles[t].file).replace_extension();
    }
    const bool drops = settings_.texture.atlas.unseen == atlas::UnseenFaces::drop;
    const auto drop = [&](std::uint32_t f) { return drops && tags[f] == labeling::FaceTag::unseen; };
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t t) {
      if (tiles[t].file.empty()) return;
      observer_.check_cancelled();
      TileModel model = tile_model(atlas.model, faces[t], pages.files(), drop);
      model.mesh.file_positions.clear();
      model.model.mesh = &model.mesh;
      io::write_gltf(stems[t], io::GltfContainer::glb, model.model, model.pages, options_);
      if (settings_.compress) compress_geometry(folder_.in_making() / tiles[t].file);
      for (const WorldPoint& p : model.mesh.positions) tiles[t].box.add(tile_from_world(options_, p));
      if (level.number > 0) tiles[t].error = geometric_error(level.error[t], level.texel_size);
    });
    note(level, atlas, tiles);
  }

  void note(const Level& level, const atlas::TextureAtlas& atlas, std::span<const Tile> tiles) {
    LevelReport report{tiles.size(), level.mesh.faces.size(), atlas.statistics.page_texels, 0, level.texel_size, 0};
    for (const Tile& tile : tiles) {
      report.error = std::max(report.error, tile.error);
      std::error_code ignored;
      if (!tile.file.empty()) report.bytes += fs::file_size(folder_.in_making() / tile.file, ignored);
    }
    observer_.end(
        fmt::format("{} tiles, {}", tiles.size(), results::readable_bytes(static_cast<double>(report.bytes))));
    report_.levels.push_back(report);
  }

  const checks::Input& input_;
  const TilesetSettings& settings_;
  io::PhotoSource& photos_;
  results::OutputFolder& folder_;
  results::Observer& observer_;
  std::vector<ViewId> views_;  ///< above level 0: those that texture something there
  io::ColorProfile profile_;
  io::ModelOptions options_;
  std::vector<std::vector<Tile>> tiles_;  ///< by level
  TilesetReport report_;
};

}  // namespace

TilesetReport tileset_into(const checks::Input& input, const TilesetSettings& settings, io::PhotoSource& photos,
                           results::OutputFolder& folder, results::Observer& observer) {
  if (!settings.texture.view_rules.empty()) throw std::invalid_argument("tileset_into takes no view_rules");
  return TilesetMaker(input, settings, photos, folder, observer).make();
}

}  // namespace gpvc::tileset
