#include "app/tiles/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/pipeline/held_bytes.h"
#include "app/pipeline/memory.h"

namespace gpvc::tiles {
namespace {

// Processor seconds of units: to start and to read the job, and for a million of what each works on. Fitted to runs on a city of
// 324 thousand faces and one of 20 million.
constexpr double kStartS = 0.8;
using namespace pipeline::held;

// Of the photos that have a tile in their frame, the share that texture some of it: 0.3 to 0.4 in both.
constexpr double kUsed = 0.35;

double million(double count) { return 1e-6 * count; }

// What the units of a level take.
class Estimates {
 public:
  Estimates(const Job& job, int level)
      : job_(job),
        tiles_(job.tiles(level)),
        level_(level),
        reduction_(job.levels[static_cast<std::size_t>(level)].reduction) {}

  void see(std::size_t group, Unit& unit) const {
    pipeline::Workload work;
    for (const ViewId id : job_.groups[group]) {
      add_photo(id, work);
      unit.photo_bytes += photo_file(id);
    }
    for (const std::uint32_t t : tiles_of_group(job_, level_, group)) {
      const TileInfo& tile = tiles_[t];
      const auto common = static_cast<double>(std::ranges::count_if(
          job_.groups[group], [&](ViewId view) { return std::ranges::binary_search(tile.views, view); }));
      work.faces += static_cast<double>(tile.faces);
      work.vertices += static_cast<double>(tile.vertices);
      work.pairs += tile.pairs * common / static_cast<double>(std::max<std::size_t>(1, tile.views.size()));
    }
    // The mesh and its numbers, sorted into another place; where tiles' faces are; what views see, all of a group and one in
    // detail; previews.
    unit.memory_bytes = kProgram + 2 * mesh(work) + 16 * kIndex * work.faces + (kRecord + kIndex) * work.pairs +
                        view(work) + previews(work);
    unit.seconds = kStartS + million(decoded(work) + 0.05 * work.pixels + 0.5 * work.pairs +
                                     (0.4 + 0.06 * work.views) * work.faces);
    unit.disk_bytes = 18 * work.pairs;
  }

  void judge(Unit& unit) const {
    double pairs = 0, faces = 0;
    for (const TileInfo& tile : tiles_) {
      pairs += own(tile, tile.pairs);
      faces += static_cast<double>(tile.faces);
    }
    const double sampled = std::min(1.0, 1.1e6 / std::max(1.0, faces)) * pairs;
    // Of the sample its records, once more in the collector, and candidates; one tile; previews.
    pipeline::Workload work;
    for (const ViewId id : job_.views) add_photo(id, work);
    unit.memory_bytes =
        kProgram + 2 * kRecord * sampled + 2 * kCandidate * sampled + 150 * most_faces() + previews(work);
    unit.seconds = kStartS + million(0.02 * pairs + 0.3 * sampled + 0.5 * faces);
  }

  void cost(std::size_t t, Unit& unit) const {
    const pipeline::Workload work = of_tile(t);
    unit.memory_bytes = kProgram + mesh(work) + (kNeighbours + 10) * work.faces + (kRecord + kCandidate) * work.pairs;
    unit.seconds = kStartS + million(0.3 * work.pairs + 2.0 * work.faces);
    unit.disk_bytes = 6.5 * work.pairs + 7 * work.faces;
  }

  void choose(std::size_t t, Unit& unit) const {
    const pipeline::Workload work = of_tile(t);
    // Fewer candidates than records: partial views of faces that others see whole are none.
    unit.memory_bytes = kProgram + mesh(work) + 3.5 * kNeighbours * work.faces + 1.9 * kCandidate * work.pairs;
    unit.seconds = kStartS + million(0.06 * work.pairs + 2.0 * work.faces) / unit.round;
    unit.disk_bytes = 4 * static_cast<double>(tiles_[t].faces);
  }

  void expose(std::size_t t, Unit& unit) const {
    const pipeline::Workload work = of_tile(t);
    // Charts are not made yet; places where photos are compared are.
    unit.memory_bytes = pipeline::memory_need(work).bake - 150 * work.faces + std::min(work.texels, 8e7);
    unit.photo_bytes = kUsed * photo_files(t);
    unit.seconds = kStartS + million(kUsed * decoded(work) + 1.5 * work.faces);
    unit.disk_bytes = 7 * static_cast<double>(tiles_[t].faces) + 0.05 * work.texels;
  }

  void level(Unit& unit) const {
    const double fields = 1e5 * static_cast<double>(job_.scene.views.size());
    unit.memory_bytes = kProgram + std::min(1e7 * static_cast<double>(tiles_.size()), 1.4e9) + fields;
    unit.seconds = kStartS + 0.05 * static_cast<double>(tiles_.size());
  }

  void bake(std::size_t t, Unit& unit) const {
    const pipeline::Workload work = of_tile(t);
    // At least one page is baked at a time.
    const double page = std::min(tiles_[t].texels, std::pow(job_.settings.texture.atlas.page_size, 2));
    unit.memory_bytes = pipeline::memory_need(work).bake + atlas::kPageBytesPerTexel * page;
    unit.photo_bytes = 2 * kUsed * photo_files(t);
    unit.seconds = kStartS + million(2 * kUsed * decoded(work) + 0.45 * work.texels + 5.0 * work.faces);
    // On level 0 pages and geometry lie beside model.obj and in the GLB.
    const double copies = level_ == 0 ? 2 : 1;
    unit.disk_bytes = copies * 0.5 * work.texels + (copies * 50 + 30) * static_cast<double>(tiles_[t].faces);
  }

  /// Of a tile above from tiles of this level, and of its border.
  void simplify(std::span<const std::uint32_t> from, Unit& unit) const {
    double faces = 0;
    for (const std::uint32_t t : from) faces += static_cast<double>(tiles_[t].faces);
    unit.memory_bytes = kProgram + 250 * faces;
    unit.seconds = kStartS + million(3 * faces);
    unit.disk_bytes = 40 * faces / 4;
  }

 private:
  void add_photo(ViewId id, pipeline::Workload& work) const {
    const Camera& camera = job_.scene.views[index(id)].camera;
    const double pixels = static_cast<double>(camera.width) * camera.height / (reduction_ * reduction_);
    work.views += 1;
    work.pixels += pixels;
    work.most_pixels = std::max(work.most_pixels, pixels);
  }
  /// Millionths of seconds for the photos of a unit, whose files have their full size on each level.
  double decoded(const pipeline::Workload& work) const { return 0.009 * work.pixels * reduction_ * reduction_; }
  double photo_file(ViewId id) const {
    double all = 0;
    const View& view = job_.scene.views[index(id)];
    for (const std::filesystem::path& file : view.band_files.empty() ? std::vector{view.photo} : view.band_files) {
      std::error_code failed;
      const std::uintmax_t bytes = std::filesystem::file_size(file, failed);
      if (!failed) all += static_cast<double>(bytes);
    }
    return all;
  }
  double photo_files(std::size_t t) const {
    double bytes = 0;
    for (const ViewId id : tiles_[t].views) bytes += photo_file(id);
    return bytes;
  }
  double most_faces() const {
    double most = 0;
    for (const TileInfo& tile : tiles_) most = std::max(most, static_cast<double>(tile.all_faces));
    return most;
  }
  /// Of what a tile knows of, borders included, the part that belongs to its own faces.
  static double own(const TileInfo& tile, double whole) {
    return whole * static_cast<double>(tile.faces) / static_cast<double>(std::max<std::size_t>(1, tile.all_faces));
  }
  pipeline::Workload of_tile(std::size_t t) const {
    const TileInfo& tile = tiles_[t];
    pipeline::Workload work;
    work.faces = static_cast<double>(tile.all_faces);
    work.vertices = static_cast<double>(tile.vertices);
    work.pairs = tile.pairs;
    work.texels = own(tile, tile.texels);
    for (const ViewId id : tile.views) add_photo(id, work);
    return work;
  }

  const Job& job_;
  const std::vector<TileInfo>& tiles_;
  int level_;
  double reduction_;
};

// Cores that units make good use of.
constexpr int kCores = 4;

class Planner {
 public:
  explicit Planner(const Job& job) : job_(job) {}

  std::vector<Unit> plan() {
    for (int level = 0; level < static_cast<int>(job_.levels.size()); ++level) add_level(level);
    Unit& finish = add({kFinishUnit, Stage::finish});
    for (int level = 0; level < static_cast<int>(job_.levels.size()); ++level)
      for (const std::uint32_t t : textured(level)) finish.after.push_back(bake_unit(level, t));
    finish.memory_bytes = kProgram;
    finish.seconds = kStartS;
    return std::move(units_);
  }

 private:
  Unit& add(Unit unit) { return units_.emplace_back(std::move(unit)); }

  /// The tiles of a level, of level 0 those that are not left over in the tree.
  std::vector<std::uint32_t> textured(int level) const {
    std::vector<std::uint32_t> tiles;
    for (std::uint32_t t = 0; t < job_.tiles(level).size(); ++t)
      if (level > 0 || job_.tiles(level)[t].faces > 0) tiles.push_back(t);
    return tiles;
  }

  void add_level(int level) {
    const Estimates estimates(job_, level);
    const std::vector<std::uint32_t> tiles = textured(level);
    if (level > 0) add_meshes(level);
    const std::vector<std::vector<std::string>> looks = add_seeing(level, estimates);
    for (const std::uint32_t t : tiles) {
      Unit& unit = add({cost_unit(level, t), Stage::cost, level, t, 0, {kJudgeUnit}, kCores});
      if (level > 0) unit.after.push_back(ring_unit(level, t));
      unit.after.insert(unit.after.end(), looks[t].begin(), looks[t].end());
      estimates.cost(t, unit);
    }
    for (int round = 1; round <= kRounds; ++round) add_choice(level, round, estimates);
    if (level == 0) add_exposure(estimates);
    for (const std::uint32_t t : tiles) {
      Unit& unit =
          add({bake_unit(level, t), Stage::bake, level, t, 0, {kLevelUnit, choose_unit(level, kRounds, t)}, kCores});
      for (const std::uint32_t other : job_.tiles(level)[t].around)
        unit.after.push_back(choose_unit(level, kRounds, other));
      estimates.bake(t, unit);
    }
  }

  void add_meshes(int level) {
    const Estimates below(job_, level - 1), here(job_, level);
    const auto tiles = static_cast<std::uint32_t>(job_.tiles(level).size());
    for (std::uint32_t t = 0; t < tiles; ++t) {
      Unit& unit = add({simplify_unit(level, t), Stage::simplify, level, t});
      const std::array<std::uint32_t, 4> children{4 * t, 4 * t + 1, 4 * t + 2, 4 * t + 3};
      if (level > 1)
        for (const std::uint32_t child : children) unit.after.push_back(simplify_unit(level - 1, child));
      below.simplify(children, unit);
    }
    for (std::uint32_t t = 0; t < tiles; ++t) {
      Unit& unit = add({ring_unit(level, t), Stage::ring, level, t, 0, {simplify_unit(level, t)}});
      std::vector<std::uint32_t> all{t};
      for (const std::uint32_t other : job_.tiles(level)[t].around) {
        all.push_back(other);
        unit.after.push_back(simplify_unit(level, other));
      }
      here.simplify(all, unit);
    }
  }

  /// Returns, per tile, the units that look at it; none on level 0, where the unit that judges photos waits for all.
  std::vector<std::vector<std::string>> add_seeing(int level, const Estimates& estimates) {
    std::vector<std::vector<std::string>> looks(job_.tiles(level).size());
    std::vector<std::string> seen;
    for (std::uint32_t g = 0; g < job_.groups.size(); ++g) {
      std::vector<std::uint32_t> tiles;
      if (level > 0) tiles = tiles_of_group(job_, level, g);
      if (level > 0 && tiles.empty()) continue;  // no unit would wait for it
      Unit& unit = add({see_unit(level, g), Stage::see, level, g, 0, {}, kCores});
      if (level > 0) unit.after.push_back(see_unit(0, g));  // which tells what its photos are
      for (const std::uint32_t t : tiles) {
        unit.after.push_back(ring_unit(level, t));
        looks[t].push_back(unit.name);
      }
      estimates.see(g, unit);
      seen.push_back(unit.name);
    }
    if (level == 0) estimates.judge(add({kJudgeUnit, Stage::judge, 0, 0, 0, std::move(seen), kCores}));
    return looks;
  }

  void add_choice(int level, int round, const Estimates& estimates) {
    const std::vector<TileInfo>& tiles = job_.tiles(level);
    std::vector<std::uint32_t> order = textured(level);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t t) { return tiles[t].color; });
    for (const std::uint32_t t : order) {
      Unit& unit = add({choose_unit(level, round, t), Stage::choose, level, t, round, {cost_unit(level, t)}, 1});
      if (round > 1) unit.after.push_back(choose_unit(level, round - 1, t));
      for (const std::uint32_t other : tiles[t].around)
        if (const std::string labels = labels_before(job_, level, round, t, other); !labels.empty())
          unit.after.push_back(labels);
      estimates.choose(t, unit);
    }
  }

  void add_exposure(const Estimates& estimates) {
    const std::vector<TileInfo>& tiles = job_.tiles(0);
    std::vector<std::string> names;
    for (const std::uint32_t t : textured(0)) {
      Unit& unit = add({expose_unit(t), Stage::expose, 0, t, 0, {cost_unit(0, t), choose_unit(0, kRounds, t)}, kCores});
      for (const std::uint32_t other : tiles[t].around) unit.after.push_back(choose_unit(0, kRounds, other));
      estimates.expose(t, unit);
      names.push_back(unit.name);
    }
    estimates.level(add({kLevelUnit, Stage::level, 0, 0, 0, std::move(names), 1}));
  }

  const Job& job_;
  std::vector<Unit> units_;
};

}  // namespace

std::string see_unit(int level, std::size_t group) { return fmt::format("see-{}-{}", level, group); }
std::string cost_unit(int level, std::size_t tile) { return fmt::format("cost-{}-{}", level, tile); }
std::string choose_unit(int level, int round, std::size_t tile) {
  return fmt::format("choose-{}-{}-{}", level, round, tile);
}
std::string expose_unit(std::size_t tile) { return fmt::format("expose-{}", tile); }
std::string bake_unit(int level, std::size_t tile) { return fmt::format("bake-{}-{}", level, tile); }
std::string simplify_unit(int level, std::size_t tile) { return fmt::format("simplify-{}-{}", level, tile); }
std::string ring_unit(int level, std::size_t tile) { return fmt::format("ring-{}-{}", level, tile); }

std::string labels_before(const Job& job, int level, int round, std::uint32_t tile, std::uint32_t neighbour) {
  if (job.tiles(level)[neighbour].color < job.tiles(level)[tile].color) return choose_unit(level, round, neighbour);
  return round > 1 ? choose_unit(level, round - 1, neighbour) : std::string();
}

std::vector<Unit> plan_units(const Job& job) { return Planner(job).plan(); }

void color_tiles(std::span<TileInfo> tiles) {
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    std::vector<std::uint8_t> taken(tiles[t].beside.size() + 1, 0);
    for (const std::uint32_t other : tiles[t].beside)
      if (other < t && static_cast<std::size_t>(tiles[other].color) < taken.size())
        taken[static_cast<std::size_t>(tiles[other].color)] = 1;
    tiles[t].color = static_cast<int>(std::ranges::find(taken, 0) - taken.begin());
  }
}

std::vector<std::vector<ViewId>> group_views(const Scene& scene, std::span<const ViewId> views, std::size_t most) {
  std::vector<ViewId> order(views.begin(), views.end());
  std::vector<std::vector<ViewId>> groups;
  // Halved across the longest axis of the cameras' places until they are small enough.
  const auto divide = [&](const auto& self, std::span<ViewId> part) -> void {
    if (part.size() <= most) {
      std::ranges::sort(part);
      groups.emplace_back(part.begin(), part.end());
      return;
    }
    checks::Box box;
    const auto centre = [&](ViewId view) -> const WorldPoint& { return scene.views[index(view)].pose.centre; };
    for (const ViewId view : part) box.add(centre(view));
    const std::array<double WorldPoint::*, 3> axes{&WorldPoint::x, &WorldPoint::y, &WorldPoint::z};
    const auto axis = *std::ranges::max_element(axes, {}, [&](auto a) { return box.high.*a - box.low.*a; });
    std::ranges::sort(part, {}, [&](ViewId view) { return std::pair(centre(view).*axis, view); });
    const std::size_t half = part.size() / 2;
    self(self, part.first(half));
    self(self, part.subspan(half));
  };
  divide(divide, order);
  return groups;
}

}  // namespace gpvc::tiles
