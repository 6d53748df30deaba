#include "app/tiles/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <future>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "app/pipeline/folder_lock.h"
#include "app/pipeline/memory.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/texture_files.h"
#include "app/tiles/done.h"
#include "app/tiles/tile_work.h"
#include "app/tileset/compressed_glb.h"
#include "app/tileset/tile_model.h"
#include "app/tileset/tileset_json.h"
#include "io/clock.h"
#include "io/files/paths.h"
#include "io/images.h"
#include "io/output_file.h"
#include "labeling/costs/view_statistics.h"

namespace gpvc::tiles {
namespace {

namespace fs = std::filesystem;
using Writer = io::WorkStore::Writer;
using Reader = io::WorkStore::Reader;

// A tile as the views of a group see it.
struct TileInGroup {
  std::uint32_t number = 0;
  std::vector<std::uint32_t> place;  ///< per face, border included, where it is in the mesh of all tiles
  std::vector<SeenView> seen{};
};

// What a view sees of a tile, from what it sees of all tiles.
class ViewDivider {
 public:
  explicit ViewDivider(std::size_t faces) : record_of_(faces, kNowhere), entry_of_(faces, kNowhere) {}

  void set(ViewId view, std::span<const std::byte> statistics, const visibility::CoverageTable& coverage) {
    for (const labeling::FaceRecord& record : records_) record_of_[record.face] = kNowhere;
    if (coverage_ != nullptr)
      for (const visibility::FaceCoverage& entry : coverage_->entries) entry_of_[index(entry.face)] = kNowhere;
    view_ = view;
    records_.resize(statistics.size() / sizeof(labeling::FaceRecord));
    if (!records_.empty()) std::memcpy(records_.data(), statistics.data(), statistics.size());
    for (std::uint32_t i = 0; i < records_.size(); ++i) record_of_[records_[i].face] = i;
    coverage_ = &coverage;
    for (std::uint32_t i = 0; i < coverage.entries.size(); ++i) entry_of_[index(coverage.entries[i].face)] = i;
  }
  /// To be called before what set() was given goes.
  void clear() { set(view_, {}, no_coverage_); }

  SeenView of_tile(std::span<const std::uint32_t> place) const {
    SeenView seen{view_, {}, {}};
    std::vector<labeling::FaceRecord> records;
    visibility::CoverageTable coverage;
    for (std::uint32_t f = 0; f < place.size(); ++f) {
      if (place[f] == kNowhere) continue;
      if (const std::uint32_t r = record_of_[place[f]]; r != kNowhere) {
        records.push_back(records_[r]);
        records.back().face = f;
      }
      if (const std::uint32_t e = entry_of_[place[f]]; e != kNowhere) {
        visibility::FaceCoverage entry = coverage_->entries[e];
        const std::size_t words =
            (static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height) + 63) / 64;
        const auto first = coverage_->words.begin() + static_cast<std::ptrdiff_t>(entry.first_word);
        entry.face = FaceId{f};
        entry.first_word = coverage.words.size();
        coverage.words.insert(coverage.words.end(), first, first + static_cast<std::ptrdiff_t>(words));
        coverage.entries.push_back(entry);
      }
    }
    const auto bytes = std::as_bytes(std::span(records));
    seen.statistics.assign(bytes.begin(), bytes.end());
    seen.coverage = pipeline::pack(view_, coverage);
    return seen;
  }

 private:
  ViewId view_ = kNoView;
  std::vector<labeling::FaceRecord> records_;
  const visibility::CoverageTable* coverage_ = nullptr;
  visibility::CoverageTable no_coverage_;
  std::vector<std::uint32_t> record_of_, entry_of_;  ///< per face of all tiles
};

void write_agreement(Writer& out, const labeling::PhotoJudgement& photos) {
  out.add(photos.agreement.size());
  for (const labeling::ViewAgreement& each : photos.agreement) {
    out.add(each.view);
    out.add(each.steps);
    out.add(each.correlation);
    out.add(each.chance);
    out.add(each.judged);
    out.add(each.by_chance);
  }
  out.add_all(photos.log2_gain);
}

labeling::PhotoJudgement read_agreement(Reader& in) {
  labeling::PhotoJudgement photos;
  for (auto count = in.get<std::size_t>(); count > 0; --count) {
    labeling::ViewAgreement each;
    each.view = in.get<ViewId>();
    each.steps = in.get<std::size_t>();
    each.correlation = in.get<double>();
    each.chance = in.get<double>();
    each.judged = in.get<bool>();
    each.by_chance = in.get<bool>();
    photos.agreement.push_back(each);
  }
  photos.log2_gain = in.get_all<double>();
  return photos;
}

// Faces of several tiles, a run of each, as a mesh of its own with what views see of them.
class Sample {
 public:
  void add(const TileMesh& tile, std::span<const std::uint32_t> faces, std::span<const SeenView> seen) {
    std::vector<std::uint32_t> vertex_of(tile.vertex.size(), kNowhere), face_of(tile.face.size(), kNowhere);
    for (const std::uint32_t f : faces) {
      Triangle corners = tile.mesh.faces[f];
      for (std::uint32_t& v : corners) {
        if (vertex_of[v] == kNowhere) {
          vertex_of[v] = static_cast<std::uint32_t>(mesh_.positions.size());
          mesh_.positions.push_back(tile.mesh.positions[v]);
        }
        v = vertex_of[v];
      }
      face_of[f] = static_cast<std::uint32_t>(mesh_.faces.size());
      mesh_.faces.push_back(corners);
    }
    for (const SeenView& view : seen) {
      std::vector<labeling::FaceRecord>& records = records_[view.view];
      labeling::FaceRecord record;
      for (std::size_t at = 0; at + sizeof record <= view.statistics.size(); at += sizeof record) {
        std::memcpy(&record, view.statistics.data() + at, sizeof record);
        if (record.face >= face_of.size() || face_of[record.face] == kNowhere) continue;
        record.face = face_of[record.face];
        records.push_back(record);
      }
    }
  }

  labeling::PhotoJudgement judge(const labeling::CostOptions& options, const Scene& scene) const {
    labeling::CandidateCollector collector(mesh_, options);
    for (const auto& [view, records] : records_) collector.add_statistics(view, std::as_bytes(std::span(records)));
    collector.set_photos(pipeline::photo_of_view(scene));
    return collector.judge_photos();
  }

 private:
  Mesh mesh_;
  std::map<ViewId, std::vector<labeling::FaceRecord>> records_;
};

std::string join_names(const std::vector<std::string>& names) { return pipeline::readable_list(names, 5); }

}  // namespace

struct UnitRunner::Outcome {
  Done done;
  void add(const JobFolder& folder, const fs::path& file) {
    done.outputs.push_back({fs::relative(file, folder.path()).string(), fs::file_size(file)});
  }
};

UnitRunner::UnitRunner(JobFolder folder, const JobSettings& settings, int downscale, pipeline::Observer& observer)
    : folder_(std::move(folder)),
      settings_(settings.tileset.texture),
      compress_(settings.tileset.compress),
      downscale_(downscale),
      observer_(observer),
      job_(folder_.read_job()),
      units_(plan_units(job_)) {}

const Unit& UnitRunner::find(const std::string& name) const {
  const auto found = std::ranges::find(units_, name, &Unit::name);
  if (found == units_.end()) throw std::invalid_argument(fmt::format("the job has no unit '{}'", name));
  return *found;
}

io::WorkKey UnitRunner::key_of(const Unit& unit) const {
  io::WorkHash hash;
  hash.add(folder_.key().bits);
  hash.add_text(unit.name);
  std::vector<std::string> missing;
  for (const std::string& before : unit.after) {
    const std::optional<io::WorkKey> key = folder_.done(before);
    if (!key) missing.push_back(before);
    hash.add(key.value_or(io::WorkKey{}).bits);
  }
  if (!missing.empty())
    throw InputError(
        folder_.path(), "unit " + unit.name,
        fmt::format("{} must be complete before: {}", missing.size() == 1 ? "a unit" : "units", join_names(missing)));
  if (unit.stage == Stage::see)
    for (const ViewId id : job_.groups[unit.number]) {
      hash.add(id);  // jobs of one input may have other groups
      for (const fs::path& file : {job_.scene.views[index(id)].photo, job_.scene.views[index(id)].mask}) {
        if (file.empty()) continue;
        std::error_code failed;
        hash.add(fs::file_size(file, failed));
        hash.add(fs::last_write_time(file, failed).time_since_epoch().count());
      }
    }
  return hash.key();
}

void UnitRunner::keep(const Unit& unit, const std::string& name, const io::WorkKey& key,
                      const std::function<void(Writer&)>& write) {
  folder_.keep(folder_.unit(unit.name), name, key, write);
  outcome_->add(folder_, folder_.unit(unit.name) / name);
}

UnitResult UnitRunner::run(const Unit& unit) {
  const io::WorkKey key = key_of(unit);
  if (folder_.done(unit.name) == key) return UnitResult::was_done;
  fs::create_directories(folder_.unit(unit.name));
  const pipeline::FolderLock lock(folder_.unit(unit.name));
  std::error_code ignored;
  fs::remove(folder_.done_file(unit.name), ignored);  // what it lists is replaced from here on
  Outcome outcome{{key}};
  outcome_ = &outcome;
  const auto start = Clock::now();
  switch (unit.stage) {
    case Stage::see:
      see(unit, key);
      break;
    case Stage::judge:
      judge(unit, key);
      break;
    case Stage::cost:
      cost(unit, key);
      break;
    case Stage::choose:
      choose(unit, key);
      break;
    case Stage::expose:
      expose(unit, key);
      break;
    case Stage::level:
      level(unit, key);
      break;
    case Stage::bake:
      bake(unit);
      break;
    case Stage::simplify:
      simplify(unit, key);
      break;
    case Stage::ring:
      ring(unit, key);
      break;
    case Stage::finish:
      finish();
      break;
  }
  outcome_ = nullptr;
  outcome.done.figures["seconds"] = seconds_since(start);
  write_done(folder_.done_file(unit.name), outcome.done);
  return UnitResult::done;
}

void UnitRunner::see(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name, "views"});
  const std::vector<ViewId>& views = job_.groups[unit.number];
  const std::vector<std::uint32_t> numbers = tiles_of_group(job_, unit.level, unit.number);
  TileUnion all;
  std::vector<TileInGroup> tiles;
  {
    std::vector<std::vector<std::uint64_t>> faces;
    for (const std::uint32_t number : numbers) {
      TileMesh tile = load_tile(folder_, unit.level, number);
      all.add(tile, number);
      faces.push_back(std::move(tile.face));
    }
    all.finish();
    for (std::size_t i = 0; i < numbers.size(); ++i) tiles.push_back({numbers[i], all.places_of(faces[i])});
  }
  const Mesh& mesh = all.mesh();
  const Scene scene = scene_at(job_, unit.level);
  io::PhotoCache photos(scene, downscale_at(unit.level));
  const auto device = visibility::find_device(settings_.visibility, settings_.device);
  visibility::VisibilityStage stage(mesh, settings_.visibility, device.get());
  labeling::CandidateCollector collector(mesh, settings_.costs);
  ViewDivider divider(mesh.faces.size());
  visibility::ViewVisibility visible;
  visibility::VisibilityStatistics sum;
  for (std::size_t n = 0; n < views.size(); ++n) {
    observer_.progress(n, views.size());
    const ViewId id = views[n];
    const View& view = scene.views[index(id)];
    auto decoded = std::async(pipeline::launch_policy(), [&photos, id] { return photos.photo(id); });
    stage.classify(view, id, photos.exclusion(id).get(), visible);
    sum += visible.statistics;
    collector.add_view(id, view, *decoded.get(), visible);
    divider.set(id, collector.statistics_of(id), visible.coverage);
    for (TileInGroup& tile : tiles)
      if (std::ranges::binary_search(job_.tiles(unit.level)[tile.number].views, id))
        tile.seen.push_back(divider.of_tile(tile.place));
    divider.clear();
    collector.forget(id);
  }
  for (const TileInGroup& tile : tiles)
    keep(unit, tile_file(tile.number), key, [&](Writer& out) { write_seen(out, tile.seen); });
  outcome_->done.figures["full"] = sum.full;
  outcome_->done.figures["partial"] = sum.partial;
  observer_.end(fmt::format("{} views of {} faces in {} tiles", views.size(),
                            pipeline::readable_count(mesh.faces.size()), tiles.size()));
}

void UnitRunner::judge(const Unit& unit, const io::WorkKey& key) {
  // As many faces as comparisons take at most (labeling/costs/agreement.h), in runs all over the mesh.
  constexpr std::size_t kRun = 16384, kRuns = 64;
  observer_.begin({unit.name, "tiles"});
  std::size_t runs = 0;
  for (const TileInfo& tile : job_.tiles(0)) runs += (tile.faces + kRun - 1) / kRun;
  const std::size_t stride = runs / kRuns + 1;
  Sample sample;
  std::size_t run = 0;
  const std::vector<TileInfo>& tiles = job_.tiles(0);
  for (std::uint32_t t = 0; t < tiles.size(); ++t) {
    observer_.progress(t, tiles.size());
    const std::size_t here = (tiles[t].faces + kRun - 1) / kRun;
    const std::size_t first = (stride - run % stride) % stride;
    run += here;
    if (first >= here) continue;
    const TileMesh tile = load_tile(folder_, 0, t);
    const std::vector<SeenView> seen = load_seen(folder_, job_, 0, t);
    const std::vector<std::uint32_t> own = tile.own(t);
    for (std::size_t r = first; r < here; r += stride) {
      const std::span<const std::uint32_t> rest = std::span(own).subspan(r * kRun);
      sample.add(tile, rest.first(std::min(kRun, rest.size())), seen);
    }
  }
  const labeling::PhotoJudgement photos = sample.judge(settings_.costs, job_.scene);
  std::vector<std::string> wrong;
  for (const labeling::ViewAgreement& each : photos.agreement)
    if (each.by_chance) wrong.push_back(job_.scene.views[index(each.view)].name);
  if (!wrong.empty()) {
    const std::string found = fmt::format("{} of {} photos agree with the others no better than chance: {}",
                                          wrong.size(), photos.agreement.size(), join_names(wrong));
    if (labeling::mostly_by_chance(photos.agreement) && !settings_.costs.keep_views)
      throw InputError(job_.scene.source, "",
                       found +
                           "; mesh, poses and photos do not fit together; a job made with "
                           "--keep-views textures all the same");
    observer_.warning(found + (settings_.costs.keep_views ? "" : "; they are left out"));
  }
  keep(unit, "photos", key, [&](Writer& out) { write_agreement(out, photos); });
  observer_.end(fmt::format("{} photos", photos.agreement.size()));
}

void UnitRunner::cost(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  const TileMesh tile = load_tile(folder_, unit.level, unit.number);
  const labeling::FaceGraph graph = labeling::face_graph(tile.mesh);
  labeling::PhotoJudgement photos;
  folder_.read(kJudgeUnit, "photos", [&](Reader& in) { photos = read_agreement(in); });
  labeling::CandidateCollector collector(tile.mesh, settings_.costs);
  pipeline::CoverageStore coverage;
  for (SeenView& seen : load_seen(folder_, job_, unit.level, unit.number)) {
    if (!collector.add_statistics(seen.view, seen.statistics))
      throw InputError(folder_.path(), "unit " + unit.name,
                       "what views see is of another mesh; make the job again by gpvc tiles");
    coverage.add(std::make_shared<const pipeline::PackedCoverage>(std::move(seen.coverage)));
    seen = {};
  }
  collector.set_photos(pipeline::photo_of_view(job_.scene));
  collector.judge_faces(photos, &graph);
  labeling::Candidates candidates = collector.finish(&graph);
  TileCosts costs{std::move(candidates.table), std::move(candidates.tags), {}};
  costs.coverage = coverage.of_partial_faces(costs.tags);
  keep(unit, "costs", key, [&](Writer& out) { write_costs(out, costs); });
  std::array<std::size_t, 3> tags{};
  for (std::size_t f = 0; f < costs.tags.size(); ++f)
    if (tile.tile[f] == unit.number) ++tags[static_cast<std::size_t>(costs.tags[f])];
  for (std::size_t i = 0; const char* name : {"seen", "partial", "filled"}) outcome_->done.figures[name] = tags[i++];
  observer_.end(fmt::format("{} candidates", pipeline::readable_count(costs.table.views.size())));
}

void UnitRunner::choose(const Unit& unit, const io::WorkKey& key) {
  const TileMesh tile = load_tile(folder_, unit.level, unit.number);
  const TileCosts costs = load_costs(folder_, unit.level, unit.number);
  const labeling::FaceGraph graph = pipeline::weighed_graph(tile.mesh, settings_.edge_weights, observer_);
  observer_.begin({unit.name, "labels", true});
  const TileInfo& info = job_.tiles(unit.level)[unit.number];
  const std::vector<ViewId> fixed = labels_of(folder_, tile, info.around, [&](std::uint32_t other) {
    return labels_before(job_, unit.level, unit.round, unit.number, other);
  });
  std::vector<ViewId> start;
  if (unit.round > 1) {
    start = fixed;
    const std::array own{unit.number};
    const std::vector<ViewId> before =
        labels_of(folder_, tile, own, [&](std::uint32_t t) { return choose_unit(unit.level, unit.round - 1, t); });
    for (std::size_t f = 0; f < start.size(); ++f)
      if (tile.tile[f] == unit.number) start[f] = before[f];
  }
  const labeling::Selection selection =
      labeling::select_views(costs.table, graph, settings_.solver, observer_.reporter(), fixed, start);
  std::vector<ViewId> labels;
  for (std::size_t f = 0; f < tile.tile.size(); ++f)
    if (tile.tile[f] == unit.number) labels.push_back(selection.labels[f]);
  keep(unit, "labels", key, [&](Writer& out) { out.add_all(labels); });
  observer_.end(fmt::format("{} faces", pipeline::readable_count(labels.size())));
}

namespace {

// What the atlas of a tile is made from.
struct TileAtlas {
  TileMesh tile;
  labeling::FaceGraph graph;
  TileCosts costs;
  std::vector<ViewId> labels;
  std::vector<std::uint8_t> border;

  TileAtlas(const JobFolder& folder, const Job& job, int level, std::uint32_t number)
      : tile(load_tile(folder, level, number)),
        graph(labeling::face_graph(tile.mesh)),
        costs(load_costs(folder, level, number)),
        border(tile.border(number)) {
    std::vector<std::uint32_t> tiles = job.tiles(level)[number].around;
    tiles.push_back(number);
    labels = labels_of(folder, tile, tiles, [&](std::uint32_t t) { return choose_unit(level, kRounds, t); });
  }
  atlas::AtlasInput input(const Scene& scene, io::PhotoSource& photos,
                          std::span<const atlas::ViewExposure> exposure) const {
    return {tile.mesh, scene, photos, graph, labels, costs.tags, costs.table, costs.coverage, border, exposure};
  }
};

// A tile's part of what the labels of all tiles come to: its faces, and the pairs whose lower face is one of them.
struct LabelFigures {
  double energy = 0;
  std::size_t pairs = 0, seams = 0;                // of faces with views; with different ones
  std::size_t pairs_across = 0, seams_across = 0;  // of these, between two tiles
};

LabelFigures label_figures(const TileAtlas& atlas, double smoothness) {
  const labeling::CostTable& table = atlas.costs.table;
  LabelFigures figures;
  for (std::size_t f = 0; f < atlas.labels.size(); ++f) {
    if (atlas.border[f] != 0 || atlas.labels[f] == kNoView) continue;
    const auto views = table.views_of(f);
    const auto found = std::ranges::lower_bound(views, static_cast<std::uint32_t>(index(atlas.labels[f])));
    if (found != views.end() && *found == index(atlas.labels[f]))
      figures.energy += double{table.costs_of(f)[static_cast<std::size_t>(found - views.begin())]};
  }
  for (std::size_t e = 0; e < atlas.graph.edges.size(); ++e) {
    const auto& [a, b] = atlas.graph.edges[e];
    const ViewId first = atlas.labels[a], second = atlas.labels[b];
    if (atlas.border[std::min(a, b)] != 0 || first == kNoView || second == kNoView) continue;
    const bool across = atlas.border[std::max(a, b)] != 0, seam = first != second;
    figures.pairs += 1;
    figures.seams += seam ? 1 : 0;
    figures.pairs_across += across ? 1 : 0;
    figures.seams_across += across && seam ? 1 : 0;
    if (seam) figures.energy += smoothness * (atlas.graph.weights.empty() ? 1 : double{atlas.graph.weights[e]});
  }
  return figures;
}

}  // namespace

void UnitRunner::expose(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  TileAtlas tile(folder_, job_, unit.level, unit.number);
  if (settings_.edge_weights != labeling::EdgeWeights::uniform)
    labeling::weigh_edges(tile.tile.mesh, settings_.edge_weights, tile.graph);
  const LabelFigures labels = label_figures(tile, settings_.solver.smoothness);
  auto& figures = outcome_->done.figures;
  figures["energy"] = labels.energy;
  figures["pairs"] = labels.pairs;
  figures["seams"] = labels.seams;
  figures["pairs_across"] = labels.pairs_across;
  figures["seams_across"] = labels.seams_across;
  std::vector<std::size_t> faces(job_.scene.views.size(), 0);
  for (std::size_t f = 0; f < tile.labels.size(); ++f)
    if (tile.border[f] == 0 && tile.labels[f] != kNoView) ++faces[index(tile.labels[f])];
  std::vector<atlas::SeamRatio> ratios;
  if (settings_.atlas.seams != atlas::SeamLeveling::none) {
    io::PhotoCache photos(job_.scene, downscale_);
    ratios = atlas::seam_ratios(tile.input(job_.scene, photos, {}));
    // Exposures of photos are known from far fewer, and those of all tiles are solved together.
    constexpr std::size_t kMost = 4000000;
    const std::size_t stride = ratios.size() * job_.tiles(0).size() / kMost + 1;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < ratios.size(); i += stride) ratios[kept++] = ratios[i];
    ratios.resize(kept);
  }
  keep(unit, "ratios", key, [&](Writer& out) {
    out.add_all(ratios);
    out.add_all(faces);
  });
  observer_.end(fmt::format("{} ratios across seams", pipeline::readable_count(ratios.size())));
}

void UnitRunner::level(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  std::vector<atlas::SeamRatio> ratios;
  std::vector<std::size_t> faces(job_.scene.views.size(), 0);
  for (std::size_t t = 0; t < job_.tiles(0).size(); ++t)
    folder_.read(expose_unit(t), "ratios", [&](Reader& in) {
      const std::vector<atlas::SeamRatio> more = in.get_all<atlas::SeamRatio>();
      ratios.insert(ratios.end(), more.begin(), more.end());
      const std::vector<std::size_t> counts = in.get_all<std::size_t>();
      if (counts.size() != faces.size()) in.refuse();
      for (std::size_t v = 0; v < counts.size(); ++v) faces[v] += counts[v];
    });
  std::vector<atlas::ViewExposure> exposure;
  if (settings_.atlas.seams != atlas::SeamLeveling::none)
    exposure = atlas::fit_exposure(job_.scene, std::move(ratios), faces);
  keep(unit, "exposure", key, [&](Writer& out) {
    out.add(exposure.size());
    for (const atlas::ViewExposure& each : exposure) {
      out.add(each.gain);
      for (const double value : {each.centre_x, each.centre_y, each.inverse_radius2, each.k1, each.k2}) out.add(value);
    }
  });
  observer_.end(fmt::format("{} photos", exposure.size()));
}

namespace {

// \param reduction of the photos that they are for
std::vector<atlas::ViewExposure> load_exposure(const JobFolder& folder, double reduction) {
  std::vector<atlas::ViewExposure> exposure;
  folder.read(kLevelUnit, "exposure", [&](Reader& in) {
    for (auto count = in.get<std::size_t>(); count > 0; --count) {
      atlas::ViewExposure each;
      each.gain = in.get<std::array<float, 3>>();
      for (double* value : {&each.centre_x, &each.centre_y, &each.inverse_radius2, &each.k1, &each.k2})
        *value = in.get<double>();
      each.centre_x /= reduction;
      each.centre_y /= reduction;
      each.inverse_radius2 *= reduction * reduction;
      exposure.push_back(each);
    }
  });
  return exposure;
}

fs::path glb_of(const JobFolder& folder, int level, std::size_t tile) {
  return folder.path() / "result" / "tiles" / fmt::format("{}_{}.glb", level, tile);
}

}  // namespace

namespace {

// Takes holes that reach beyond the tile's faces into what is baked, with the faces around them: a hole is filled from all
// around, and both tiles that share it must come to the same colours where they meet.
void take_in_holes(TileAtlas& atlas) {
  // A hole that goes on farther is cut there, where its colours hardly depend on what lies beyond.
  constexpr int kHoleEdges = 24;
  const auto neighbours = group_neighbours(atlas.labels.size(), atlas.graph.edges);
  const auto unseen = [&](std::uint32_t f) { return atlas.costs.tags[f] == labeling::FaceTag::unseen; };
  std::vector<std::uint32_t> hole;
  for (std::uint32_t f = 0; f < atlas.labels.size(); ++f)
    if (atlas.border[f] == 0 && unseen(f)) hole.push_back(f);
  for (std::size_t begin = 0, ring = 0; ring < kHoleEdges && begin < hole.size(); ++ring)
    for (const std::size_t end = hole.size(); begin < end; ++begin)
      for (const std::uint32_t next : std::as_const(neighbours)[hole[begin]])
        if (unseen(next) && std::exchange(atlas.border[next], std::uint8_t{0}) != 0) hole.push_back(next);
  for (const std::uint32_t f : hole)
    for (const std::uint32_t next : std::as_const(neighbours)[f])
      if (!unseen(next)) atlas.border[next] = 0;
}

}  // namespace

void UnitRunner::bake(const Unit& unit) {
  TileAtlas tile(folder_, job_, unit.level, unit.number);
  take_in_holes(tile);
  const std::vector<std::uint32_t> own = tile.tile.own(unit.number);
  if (own.empty()) return;
  const Level& level = job_.levels[static_cast<std::size_t>(unit.level)];
  const std::vector<atlas::ViewExposure> exposure = load_exposure(folder_, level.reduction);
  const std::vector<ViewId>& views = level.tiles[unit.number].views;
  const Scene scene = scene_at(job_, unit.level);
  const pipeline::Input input{scene, tile.tile.mesh, views, folder_.path()};
  pipeline::Settings settings = settings_;
  settings.atlas.texel_size = level.texel_size;
  const pipeline::MemoryPlan memory = pipeline::plan_painting(input, settings);
  io::PhotoCache photos(scene, downscale_at(unit.level));
  observer_.begin({unit.name, "steps"});
  const atlas::AtlasInput from = tile.input(scene, photos, exposure);
  const atlas::AtlasPlan plan = pipeline::plan_and_note(from, settings.atlas, observer_);
  // Levels above have no model.obj; their pages are in the GLB alone.
  const bool finest = unit.level == 0;
  const fs::path glb = glb_of(folder_, unit.level, unit.number);
  const fs::path obj =
      finest ? folder_.path() / "result" / "obj" / fmt::to_string(unit.number) : folder_.unit(unit.name);
  fs::create_directories(obj);
  fs::create_directories(glb.parent_path());
  std::vector<io::PageFile> pages;
  for (std::size_t p = 0; p < plan.estimate().pages; ++p)
    pages.push_back({obj / pipeline::page_name(p, settings.output.texture), settings.output.texture});
  atlas::BakeOptions options = pipeline::bake_options(plan, settings, memory, photos);
  options.scratch_folder = folder_.unit(unit.name);
  options.take_page = [&](std::size_t number, const Image& page) {
    observer_.check_cancelled();
    io::write_image(pages[number].file, page, settings.output.texture, settings.output.quality, job_.color_profile);
  };
  const atlas::TextureAtlas atlas = pipeline::bake_and_end(plan, from, settings.atlas, observer_, options);
  const bool drops = settings.atlas.unseen == atlas::UnseenFaces::drop;
  tileset::TileModel model = tileset::tile_model(atlas.model, own, pages, [&](std::uint32_t f) {
    return drops && tile.costs.tags[f] == labeling::FaceTag::unseen;
  });
  model.model.mesh = &model.mesh;
  if (finest) io::write_obj(obj / "model.obj", model.model, model.pages, job_.model);
  fs::path stem = glb;
  io::write_gltf(stem.replace_extension(), io::GltfContainer::glb, model.model, model.pages, job_.model);
  if (compress_) tileset::compress_geometry(glb);
  outcome_->add(folder_, glb);
  for (const io::PageFile& page : pages) {
    if (finest)
      outcome_->add(folder_, page.file);
    else
      fs::remove(page.file);
  }
  if (finest)
    for (const char* name : {"model.obj", "model.mtl"}) outcome_->add(folder_, obj / name);
  auto& figures = outcome_->done.figures;
  figures["charts"] = atlas.statistics.charts;
  figures["page_texels"] = atlas.statistics.page_texels;
  figures["seam_edges"] = atlas.statistics.seam_edges;
  figures["seam_step_before"] = atlas.statistics.seam_step_before;
  figures["seam_step_after"] = atlas.statistics.seam_step_after;
}

namespace {

// What viewers take an empty tile for: all of it is missing.
double diagonal_of(const std::vector<TileInfo>& tiles) {
  pipeline::Box all;
  for (const TileInfo& tile : tiles)
    for (const WorldPoint& corner : pipeline::corners(tile.written_box))
      if (tile.faces > 0) all.add(corner);
  return std::hypot(all.high.x - all.low.x, all.high.y - all.low.y, all.high.z - all.low.z);
}

}  // namespace

void UnitRunner::simplify(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  TileUnion children;
  double error = 0;
  for (std::uint32_t child = 4 * unit.number; child < 4 * unit.number + 4; ++child) {
    const CoarseTile tile = load_own(folder_, unit.level - 1, child);
    children.add(tile.tile, child);
    error = std::max(error, tile.error);
  }
  children.finish();
  CoarseTile coarse = coarse_tile(children, unit.number);
  coarse.error += error;
  keep(unit, "tile", key, [&](Writer& out) { write_coarse(out, coarse); });
  outcome_->done.figures["faces"] = coarse.tile.face.size();
  outcome_->done.figures["error"] = coarse.error;
  observer_.end(fmt::format("{} faces", pipeline::readable_count(coarse.tile.face.size())));
}

void UnitRunner::ring(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  TileUnion all;
  all.add(load_own(folder_, unit.level, unit.number).tile, unit.number);
  for (const std::uint32_t other : job_.tiles(unit.level)[unit.number].around)
    all.add(load_own(folder_, unit.level, other).tile, other);
  all.finish();
  const TileMesh tile = with_border(all, unit.number);
  keep(unit, "tile", key, [&](Writer& out) { write(out, tile); });
  observer_.end(fmt::format("{} faces with the border", pipeline::readable_count(tile.face.size())));
}

tileset::Tile UnitRunner::tile_of_result(int level, std::size_t number) const {
  tileset::Tile tile;
  const fs::path glb = glb_of(folder_, level, number);
  if (!io::is_file(glb)) return tile;  // it has no faces
  tile.file = fs::relative(glb, folder_.path() / "result").string();
  for (const WorldPoint& corner : pipeline::corners(job_.tiles(level)[number].written_box))
    tile.box.add(tileset::tile_from_world(job_.model, corner));
  if (level == 0) return tile;
  const double texel = job_.levels[static_cast<std::size_t>(level)].texel_size;
  tile.error = tileset::geometric_error(load_own(folder_, level, static_cast<std::uint32_t>(number)).error, texel);
  return tile;
}

void UnitRunner::finish() {
  observer_.begin({kFinishUnit});
  const double diagonal = diagonal_of(job_.tiles(0));
  std::vector<std::vector<tileset::Tile>> levels;
  for (int k = 0; k < static_cast<int>(job_.levels.size()); ++k) {
    std::vector<tileset::Tile>& tiles = levels.emplace_back();
    for (std::size_t t = 0; t < job_.tiles(k).size(); ++t) tiles.push_back(tile_of_result(k, t));
  }
  // Without levels of detail, tiles above the leaves have nothing to show, so that viewers go on to the leaves from anywhere.
  while (levels.back().size() > 1) levels.emplace_back(levels.back().size() / 4, tileset::Tile{{}, {}, diagonal});
  const fs::path file = folder_.path() / "result" / "tileset.json";
  fs::create_directories(file.parent_path());
  io::OutputFile out(file);
  out.write(tileset::tileset_text(levels, job_.model));
  out.commit();
  outcome_->add(folder_, file);
  auto& figures = outcome_->done.figures;
  std::map<std::string, double> sums;
  double steps_before = 0, steps_after = 0;
  for (const Unit& unit : units_) {
    const std::optional<Done> done = unit.level == 0 ? read_done(folder_.done_file(unit.name)) : std::nullopt;
    if (!done) continue;
    for (const char* name : {"full", "partial", "seen", "filled", "energy", "pairs", "seams", "pairs_across",
                             "seams_across", "charts", "page_texels", "seam_edges"})
      if (done->figures.contains(name))
        sums[std::string(name_of(kStageNames, unit.stage)) + "." + name] += done->figures[name].get<double>();
    if (!done->figures.contains("seam_step_after")) continue;
    const double edges = done->figures["seam_edges"].get<double>();
    steps_before += edges * done->figures["seam_step_before"].get<double>();
    steps_after += edges * done->figures["seam_step_after"].get<double>();
  }
  for (const auto& [name, value] : sums) {
    figures[name] = value;
    observer_.figure(name, value);
  }
  const double edges = std::max(1.0, sums["bake.seam_edges"]);
  figures["seam_step_before"] = steps_before / edges;
  figures["seam_step_after"] = steps_after / edges;
  observer_.end(fmt::format("energy {:.0f}, seam step {:.1f} to {:.1f}", sums["expose.energy"], steps_before / edges,
                            steps_after / edges));
}

}  // namespace gpvc::tiles
