// The units that look at photos: what they see of the faces, and how they agree with each other.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "app/checks/scene_fit.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/texture_files.h"
#include "app/pipeline/view_loop.h"
#include "app/pipeline/viewpoint.h"
#include "app/tiles/done.h"
#include "app/tiles/sound.h"
#include "app/tiles/tile_work.h"
#include "app/tiles/units.h"
#include "labeling/face_record.h"
#include "visibility/visibility.h"

namespace gpvc::tiles {
namespace {

// A tile as the views of a group see it.
struct TileInGroup {
  std::uint32_t number = 0;
  std::vector<std::uint32_t> place;  ///< per face, border included, where it is in the mesh of all tiles
  std::vector<TileSight> sights{};
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

  TileSight of_tile(std::span<const std::uint32_t> place) const {
    TileSight seen{view_, {}, {}};
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

// Faces of several tiles, a run of each, as a mesh of its own with what views see of them.
class Sample {
 public:
  void add(const TileMesh& tile, std::span<const std::uint32_t> faces, std::span<const TileSight> seen) {
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
    for (const TileSight& view : seen) {
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

  const Mesh& mesh() const { return mesh_; }
  /// Adds what was seen to a collector of mesh().
  void give(labeling::CandidateCollector& collector) const {
    for (const auto& [view, records] : records_) collector.add_statistics(view, std::as_bytes(std::span(records)));
  }

 private:
  Mesh mesh_;
  std::map<ViewId, std::vector<labeling::FaceRecord>> records_;
};

}  // namespace

void UnitRunner::see(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name, "views"});
  const std::vector<ViewId>& views = job_.groups[unit.number];
  const std::vector<std::uint32_t> numbers = tiles_of_group(job_, unit.level, unit.number);
  TileUnion all;
  std::vector<TileInGroup> tiles;
  {
    std::vector<std::vector<std::uint64_t>> faces;
    for (const std::uint32_t number : numbers) {
      TileMesh tile = load_tile(folder_, job_, unit.level, number);
      all.add(tile, number);
      faces.push_back(std::move(tile.face));
    }
    all.finish();
    for (std::size_t i = 0; i < numbers.size(); ++i) tiles.push_back({numbers[i], all.places_of(faces[i])});
  }
  const Scene scene = scene_at(job_, unit.level);
  const pipeline::Input input{scene, all.mesh(), views, job_.mesh_file};
  io::PhotoCache photos(scene, 0, &photos_.hashes());
  // Pages have the profile that the job's first photo had when the job was made.
  const ViewId first = job_.views.front();
  const std::filesystem::path& first_photo = scene.views[index(first)].photo;
  if (unit.level == 0 && std::ranges::binary_search(views, first) &&
      pipeline::profile_of_photo(scene, first, photos) != job_.color_profile)
    throw InputError(first_photo, "", "has another colour profile than the job's pages", {Cure::make_job});
  labeling::CandidateCollector collector(input.mesh, settings_.costs);
  const checks::FitLook look(input, job_.tie_points, job_.views);
  ViewDivider divider(input.mesh.faces.size());
  visibility::VisibilityStatistics sum;
  std::vector<ViewTells> told;
  pipeline::look_at_views({input, settings_, photos, observer_},
                          {.up = pipeline::up_direction(job_.scene, job_.views),
                           .decoded = [&](ViewId id, const Image& photo, const visibility::ViewVisibility& visible) {
                             sum += visible.statistics;
                             collector.add_view(id, scene.views[index(id)], photo, visible);
                             divider.set(id, collector.statistics_of(id), visible.coverage);
                             for (TileInGroup& tile : tiles)
                               if (std::ranges::binary_search(job_.tiles(unit.level)[tile.number].views, id))
                                 tile.sights.push_back(divider.of_tile(tile.place));
                             divider.clear();
                             collector.forget(id);
                             if (unit.level > 0) return;
                             told.push_back({id, look.at(id, photo, visible)});
                           }});
  for (const TileInGroup& tile : tiles) put(unit, tile_file(tile.number), key, tile.sights);
  if (unit.level == 0) put(unit, "views", key, told);
  done_->figures["full"] = sum.full;
  done_->figures["partial"] = sum.partial;
  observer_.end(fmt::format("{} views of {} faces in {} tiles", views.size(),
                            results::readable_count(input.mesh.faces.size()), tiles.size()));
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
    const TileMesh tile = load_tile(folder_, job_, 0, t);
    const std::vector<TileSight> seen = load_sights(folder_, job_, 0, t, tile.mesh);
    const std::vector<std::uint32_t> own = tile.own(t);
    for (std::size_t r = first; r < here; r += stride) {
      const std::span<const std::uint32_t> rest = std::span(own).subspan(r * kRun);
      sample.add(tile, rest.first(std::min(kRun, rest.size())), seen);
    }
  }
  checks::FitEvidence evidence(job_.scene.views.size());
  evidence.points = job_.tie_points;
  for (std::size_t g = 0; g < job_.groups.size(); ++g)
    for (ViewTells& view : folder_.get<std::vector<ViewTells>>(
             see_unit(0, g), "views", [&](std::span<const ViewTells> found) { return is_sound(found, job_.scene); }))
      evidence.add(view.view, std::move(view.fit));
  labeling::CandidateCollector collector(sample.mesh(), settings_.costs);
  sample.give(collector);
  collector.set_photos(pipeline::photo_of_view(job_.scene));
  const labeling::PhotoJudgement photos = collector.judge_photos();
  collector.judge_faces(photos);
  const labeling::Candidates candidates = collector.candidates();
  const pipeline::Input input{job_.scene, sample.mesh(), job_.views, job_.mesh_file};
  const checks::SceneCase scene{input, candidates, evidence, pipeline::tolerance_of(settings_)};
  std::optional<checks::SceneFit> fit;
  if (pipeline::is_exact(settings_.visibility.method)) fit = checks::measure_scene(scene);
  put(unit, "photos", key, photos);
  observer_.end(fmt::format("{} photos", photos.agreement.size()));
  checks::judge_scene(scene, fit, observer_);
}

}  // namespace gpvc::tiles
