#include "app/tileset/tileset.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "app/checks/frame_check.h"
#include "app/pipeline/bake_into.h"
#include "app/pipeline/checkpoint.h"
#include "app/pipeline/memory.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/texture_files.h"
#include "app/tileset/tile_files.h"
#include "app/tileset/tile_tree.h"
#include "app/tileset/tileset_json.h"
#include "io/freed_memory.h"
#include "io/grouping.h"

namespace gpvc::tileset {
namespace {

namespace fs = std::filesystem;

// A level with what it is textured with.
struct Level {
  const Mesh& mesh;
  std::span<const std::uint32_t> tile;  ///< per face
  std::span<const double> error;        ///< per tile, of its surface
  int number = 0;                       ///< 0: the leaves
  double texel_size = 0;
};

// Pages are those of tiles, of which the settings of a texture know nothing.
atlas::KeptPages pages_of_tiles(pipeline::Checkpoint& checkpoint, std::span<const std::uint32_t> tile) {
  atlas::KeptPages kept = checkpoint.pages();
  io::WorkHash hash;
  hash.add(kept.key);
  hash.add(tile);
  kept.key = hash.key();
  return kept;
}

class TilesetMaker {
 public:
  TilesetMaker(const pipeline::Run& run, const TilesetSettings& settings, pipeline::OutputFolder& folder)
      : run_(run),
        input_(run.input),
        settings_(settings),
        folder_(folder),
        observer_(run.observer),
        leaves_(leaf_count(run.input.mesh.faces.size(), settings.faces_per_tile)),
        views_(run.input.views.begin(), run.input.views.end()),
        listed_(pipeline::listed_vertices(run.settings.view_rules, run.input.mesh)),
        profile_(pipeline::profile_of_photos(run)) {}

  TilesetReport make() {
    const int depth = tree_depth(leaves_);
    const std::vector<std::uint32_t> leaf = leaf_of_faces(input_.mesh, up(), leaves_);
    const double photo_texel = median_pixel();
    std::vector<double> exact(std::size_t{1} << (2 * depth), 0.0);
    const std::vector<pipeline::ViewRule>& rules = run_.settings.view_rules;
    make_level({input_.mesh, leaf, exact, 0, run_.settings.atlas.texel_size}, depth, rules);
    LevelMesh above;
    std::vector<std::uint32_t> vertex;  // per vertex of the level, its number on level 0
    for (int k = 1; k <= depth; ++k) {
      above = k == 1 ? coarser_level(input_.mesh, leaf, exact) : coarser_level(above.mesh, above.tile, above.error);
      if (k > 1)
        for (std::uint32_t& v : above.vertex) v = vertex[v];
      vertex = above.vertex;
      const double finest = std::max(photo_texel, run_.settings.atlas.texel_size);
      make_level({above.mesh, above.tile, above.error, k, std::ldexp(finest, k)}, depth,
                 pipeline::rules_of_coarser(rules, listed_, above.mesh, vertex));
    }
    folder_.file("tileset.json");
    folder_.file("index.html");
    write_tileset(folder_.in_making(), tiles_, options_, settings_.place);
    report_.placing = remark_on_placing(options_, settings_.place);
    return std::move(report_);
  }

 private:
  // The length that a pixel covers on the mesh.
  double median_pixel() const {
    const std::vector<double> lengths = checks::sampling_distances(input_.mesh, input_.scene, input_.views);
    return lengths.empty() ? 0 : lengths[lengths.size() / 2];
  }

  void make_level(const Level& level, int depth, std::vector<pipeline::ViewRule> rules) {
    if (depth > 0)
      observer_.note(
          fmt::format("level {} of {}: {} faces in {} tiles{}", level.number, depth,
                      results::readable_count(level.mesh.faces.size()), level.number > 0 ? level.error.size() : leaves_,
                      level.number > 0 ? fmt::format(", texels of {:.3g} units or more", level.texel_size) : ""));
    pipeline::Settings settings = run_.settings;
    settings.atlas.texel_size = level.texel_size;
    settings.view_rules = std::move(rules);
    // Level 0 has judged photos and mesh.
    const bool judged = level.number > 0;
    if (judged) settings.costs.keep_odd_views = true;
    const pipeline::Input input{input_.scene, level.mesh, views_, input_.mesh_file};
    const pipeline::MemoryPlan memory = pipeline::plan_memory(input, settings);
    const pipeline::FileSizes sizes = pipeline::predicted_sizes(input, settings, memory.work.texels);
    io::CoarsePhotos photos = pipeline::with_coarse_photos({input, settings, run_.photos, observer_}, memory.work,
                                                           sizes.likely, folder_.in_making());
    pipeline::Run run{input, settings, photos, observer_};
    // Each level takes a quarter of the one below: a third more together.
    if (level.number == 0) folder_.expect_space(sizes.least, sizes.likely * 4 / 3, observer_);
    std::optional<pipeline::Checkpoint> checkpoint =
        pipeline::open_checkpoint(run, memory, sizes, folder_, fmt::format("level-{}", level.number));
    if (checkpoint) run.kept = &*checkpoint;
    pipeline::Choice chosen = pipeline::see_and_choose(run, memory, {.judged = judged});
    if (level.number == 0) {
      options_ =
          pipeline::model_options(input, chosen.selection.labels, settings.output, pipeline::Coordinates::of_scene);
      options_.normals = false;  // they would differ along the borders of tiles
      options_.copyright = settings_.copyright;
      options_.coding = tile_coding(settings.output, settings_.compress);
      keep_used_views(chosen.selection.labels);
    }
    atlas::AtlasInput from =
        pipeline::atlas_input(input, run.photos, chosen.graph, chosen.seen, chosen.selection.labels);
    from.tile = level.tile;
    PageFiles pages(folder_.in_making(), "page-", settings.output, profile_, level.number == 0);
    pipeline::BakeSpace space{.scratch_folder = folder_.in_making()};
    if (checkpoint) space.kept = pages_of_tiles(*checkpoint, level.tile);
    const atlas::TextureAtlas atlas =
        pipeline::bake_into(run, from, pipeline::with_coverage(memory, chosen.seen.coverage), space, &pages);
    if (checkpoint) checkpoint->warn_of_failure(observer_);
    write_tiles(level, atlas, chosen, pages.files());
    if (level.number == depth) write_preview(input, atlas, chosen.selection.labels, pages.files());
    pages.remove();
    release_freed_memory();
  }

  io::UpAxis up() const { return run_.settings.output.up.value_or(pipeline::scene_up(input_.scene, run_.input.views)); }

  void keep_used_views(std::span<const ViewId> labels) {
    std::vector<std::uint8_t> used(input_.scene.views.size(), 0);
    for (const ViewId label : labels)
      if (label != kNoView) used[index(label)] = 1;
    std::erase_if(views_, [&](ViewId view) { return used[index(view)] == 0; });
  }

  // Of a tile's pages, in the order of its glTF's images.
  void keep_samples(std::size_t tile, std::span<const io::PageFile> pages) {
    const std::lock_guard lock(mutex_);
    const io::SampleFormat format = run_.settings.output.band_format;
    for (std::size_t n = 0; n < pages.size(); ++n)
      std::filesystem::rename(pipeline::samples_of(pages[n].file, format),
                              folder_.file(pipeline::samples_of(fmt::format("tiles/0_{}_{}.glb", tile, n), format)));
  }

  void write_tiles(const Level& level, const atlas::TextureAtlas& atlas, const pipeline::Choice& chosen,
                   std::span<const io::PageFile> pages) {
    observer_.begin({"write"});
    const std::size_t count = level.error.size();
    const Grouped<std::uint32_t> faces = group_items<std::uint32_t>(count, [&](const auto& add) {
      for (std::uint32_t f = 0; f < level.tile.size(); ++f) add(level.tile[f], f);
    });
    std::vector<Tile>& tiles = tiles_.emplace_back(count);
    for (std::size_t t = 0; t < count; ++t) {
      if (faces[t].empty()) continue;
      tiles[t].file = fmt::format("tiles/{}_{}.glb", level.number, t);
      folder_.file(tiles[t].file);
    }
    const auto drop = [&](std::uint32_t f) {
      return atlas::is_dropped(run_.settings.atlas.unseen, chosen.seen.candidates.tags[f]);
    };
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t t) {
      if (tiles[t].file.empty()) return;
      observer_.check_cancelled();
      TileModel model = tile_model(atlas.model, faces[t], pages, drop);
      add_photos(model, input_.scene, faces[t], chosen.selection.labels);
      if (level.number == 0 && input_.scene.bands) keep_samples(t, model.pages);
      write_tile(folder_.in_making() / tiles[t].file, model, options_, run_.settings.output, folder_.in_making());
      for (const WorldPoint& p : model.mesh.positions) tiles[t].box.add(tile_from_world(options_, p));
      if (level.number > 0) tiles[t].error = geometric_error(level.error[t], level.texel_size);
    });
    note(level, atlas, tiles);
  }

  // Of the coarsest level, which has enough texels for a picture of the whole.
  void write_preview(const pipeline::Input& input, const atlas::TextureAtlas& atlas, std::span<const ViewId> labels,
                     std::span<const io::PageFile> pages) {
    const int reduction = pipeline::preview_reduction(atlas.statistics.page_texels);
    std::vector<Image> reduced;
    for (const io::PageFile& page : pages) reduced.push_back(io::reduce_image(io::read_image(page.file), reduction));
    pipeline::write_preview(input, atlas.model, reduced, labels, up(), profile_, folder_.file("preview.png"));
  }

  void note(const Level& level, const atlas::TextureAtlas& atlas, std::span<const Tile> tiles) {
    LevelReport report{level.number > 0 ? tiles.size() : leaves_,
                       level.mesh.faces.size(),
                       atlas.statistics.page_texels,
                       0,
                       level.texel_size,
                       0};
    for (const Tile& tile : tiles) {
      report.error = std::max(report.error, tile.error);
      std::error_code ignored;
      if (!tile.file.empty()) report.bytes += fs::file_size(folder_.in_making() / tile.file, ignored);
    }
    observer_.end(
        fmt::format("{} tiles, {}", report.tiles, results::readable_bytes(static_cast<double>(report.bytes))));
    report_.levels.push_back(report);
  }

  const pipeline::Run& run_;
  const pipeline::Input& input_;
  const TilesetSettings& settings_;
  pipeline::OutputFolder& folder_;
  pipeline::Observer& observer_;
  std::size_t leaves_;                          ///< tiles of level 0 that have faces
  std::vector<ViewId> views_;                   ///< above level 0: those that texture something there
  std::vector<pipeline::NumberRanges> listed_;  ///< by the rules, on level 0
  io::ColorProfile profile_;
  io::ModelOptions options_;
  std::mutex mutex_;                      ///< of files that are promised by several threads
  std::vector<std::vector<Tile>> tiles_;  ///< by level
  TilesetReport report_;
};

}  // namespace

TilesetReport tileset_into(const pipeline::Run& run, const TilesetSettings& settings, pipeline::OutputFolder& folder) {
  checks::validate(run.input);
  pipeline::check_band_format(run.input, run.settings.output);
  refuse_place(run.input.scene, run.input.mesh.positions.front(), settings.place);
  return TilesetMaker(run, settings, folder).make();
}

}  // namespace gpvc::tileset
