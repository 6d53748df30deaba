// Derives candidates and costs from the statistics per face and view: rejects outliers, prefers full views to partial
// ones, and compares the qualities of a face's views.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include "io/freed_memory.h"
#include "labeling/costs/agreement.h"
#include "labeling/costs/defocus.h"
#include "labeling/costs/face_choice.h"
#include "labeling/costs/face_records.h"
#include "labeling/costs/outliers.h"
#include "labeling/costs/unmodelled.h"
#include "labeling/labeling.h"

namespace gpvc::labeling {
namespace {

/// Per view, faces that it sees whole, as two others do at least, and those of them where it is an outlier.
struct OutlierCounts {
  std::vector<std::size_t> faces, outliers;

  explicit OutlierCounts(std::size_t views) : faces(views), outliers(views) {}

  void add(std::span<const ViewRecord> of_face) {
    constexpr std::ptrdiff_t kLeastViews = 3;
    const auto full = [](const ViewRecord& item) { return item.record->is_full(); };
    if (std::ranges::count_if(of_face, full) < kLeastViews) return;
    for (const ViewRecord& item : of_face) {
      if (!full(item)) continue;
      ++faces[item.view];
      outliers[item.view] += is_outlier(*item.record) ? 1 : 0;
    }
  }
  void add(const OutlierCounts& other) {
    for (std::size_t v = 0; v < faces.size(); ++v) {
      faces[v] += other.faces[v];
      outliers[v] += other.outliers[v];
    }
  }
  std::vector<double> shares() const {
    std::vector<double> result;
    for (std::size_t v = 0; v < faces.size(); ++v)
      result.push_back(faces[v] == 0 ? 0 : static_cast<double>(outliers[v]) / static_cast<double>(faces[v]));
    return result;
  }
};

/// The candidates of a chunk of faces.
struct TablePart {
  std::vector<std::uint32_t> views;
  std::vector<float> costs;
  std::vector<std::uint32_t> counts;  ///< per face
  std::vector<FaceTag> tags;
  std::vector<FaceId> refused;
  std::size_t full = 0, partial = 0, rejected = 0;
  OutlierCounts of_views;

  /// For so many faces and candidates at most: growing would take twice the memory for a moment.
  TablePart(std::size_t faces, std::size_t candidates, std::size_t of_so_many_views) : of_views(of_so_many_views) {
    views.reserve(candidates);
    costs.reserve(candidates);
    counts.reserve(faces);
    tags.reserve(faces);
  }

  void add(const FaceChoice& choice, const CostOptions& options) {
    const float best = choice.quality.empty() ? 0 : *std::max_element(choice.quality.begin(), choice.quality.end());
    counts.push_back(static_cast<std::uint32_t>(choice.taken.size()));
    tags.push_back(choice.tag);
    rejected += choice.rejected;
    for (std::size_t i = 0; i < choice.taken.size(); ++i) {
      const FaceRecord& record = *choice.taken[i].record;
      (record.is_full() ? full : partial) += 1;
      views.push_back(choice.taken[i].view);
      costs.push_back(static_cast<float>(cost_of(record, choice.quality[i], best, options).total()));
    }
  }
};

/// The candidates of all chunks. Frees the memory of each part once it is taken over.
Candidates joined(std::vector<std::optional<TablePart>>& parts, std::size_t faces) {
  Candidates result;
  OutlierCounts of_views(parts.empty() ? 0 : parts[0]->of_views.faces.size());
  CostTable& table = result.table;
  std::size_t total = 0;
  for (const auto& part : parts) total += part->views.size();
  table.first.reserve(faces + 1);
  table.views.reserve(total);
  table.costs.reserve(total);
  result.tags.reserve(faces);
  table.first.push_back(0);
  for (std::optional<TablePart>& part : parts) {
    for (const std::uint32_t count : part->counts) table.first.push_back(table.first.back() + count);
    table.views.insert(table.views.end(), part->views.begin(), part->views.end());
    table.costs.insert(table.costs.end(), part->costs.begin(), part->costs.end());
    result.tags.insert(result.tags.end(), part->tags.begin(), part->tags.end());
    result.refused.insert(result.refused.end(), part->refused.begin(), part->refused.end());
    result.full += part->full;
    result.partial += part->partial;
    result.rejected += part->rejected;
    of_views.add(part->of_views);
    part.reset();
  }
  result.outlier_share = of_views.shares();
  return result;
}

using TableParts = std::vector<std::optional<TablePart>>;

/// The candidates of each chunk of faces, from what `allowed` leaves of the records.
TableParts table_parts(RecordsByView& by_view, std::size_t faces, const CostOptions& options,
                       const CandidateCollector::Allowed& allowed) {
  TableParts parts(chunk_count(faces));
  const std::size_t views = view_count(by_view);
  for_each_chunk(by_view, faces, 1, [&](std::size_t chunk, const Grouped<ViewRecord>& records) {
    TablePart& part = parts[chunk].emplace(records.groups(), records.items.size(), views);
    FaceChoice choice;
    std::vector<ViewRecord> left;
    for (std::size_t n = 0; n < records.groups(); ++n) {
      std::span<const ViewRecord> of_face = records[n];
      part.of_views.add(of_face);
      if (allowed) {
        const FaceId face{static_cast<std::uint32_t>(chunk * kChunkFaces + n)};
        left.assign(of_face.begin(), of_face.end());
        std::erase_if(left, [&](const ViewRecord& item) { return !allowed(face, ViewId{item.view}); });
        if (left.empty() && !of_face.empty()) part.refused.push_back(face);
        of_face = left;
      }
      choose(of_face, options, choice);
      part.add(choice, options);
    }
  });
  return parts;
}

/// Removes all records of faces that more views show background, or a mixture with it, in place of than see at least half of:
/// where photos show the sky behind a face, there is no surface, and what the others show there stands in front of it.
void leave_out_background(RecordsByView& by_view, const RecordsByView& background, std::size_t faces) {
  std::vector<std::int32_t> balance;  // per face, views that see it less those that show background
  for (const auto& [view, shown] : background) {
    if (balance.empty() && !shown.empty()) balance.assign(faces, 0);
    for (const FaceRecord& record : shown) --balance[record.face];
  }
  if (balance.empty()) return;
  for (const auto& [view, records] : by_view)
    for (const FaceRecord& record : records)
      if (record.visible >= kWholeShare / 2) ++balance[record.face];
  for (auto& [view, records] : by_view)
    std::erase_if(records, [&](const FaceRecord& record) { return balance[record.face] < 0; });
}

void tag_background(const std::vector<bool>& faces, Candidates& candidates) {
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (faces[f]) candidates.tags[f] = FaceTag::background;
}

}  // namespace

struct CandidateCollector::State {
  const Mesh& mesh;
  CostOptions options;
  std::vector<std::uint8_t> wanted;
  RecordsByView by_view;
  RecordsByView background{};                             ///< records without a surface
  std::optional<ViewScratch> scratch{std::in_place};      ///< empty after the last view
  std::optional<std::vector<ViewAgreement>> agreement{};  ///< once views are judged
  std::vector<std::uint32_t> photo_of_view{};             ///< or empty
  std::optional<Grouped<std::uint32_t>> neighbours{};     ///< while views are judged

  void add(ViewId id, std::vector<FaceRecord> records) {
    const auto view = static_cast<std::uint32_t>(index(id));
    std::vector<FaceRecord> shown;
    std::ranges::copy_if(records, std::back_inserter(shown), std::not_fn(&FaceRecord::has_surface));
    if (!shown.empty()) std::erase_if(records, std::not_fn(&FaceRecord::has_surface));
    by_view[view] = std::move(records);
    if (!shown.empty()) background[view] = std::move(shown);
  }

  /// Per face true if views show background in its place, no fewer than show a mixture with it, and none sees it; empty where no
  /// view shows any.
  std::vector<bool> background_faces() const {
    if (background.empty()) return {};
    std::vector<std::int32_t> balance(mesh.faces.size(), 0);
    std::vector<bool> found(mesh.faces.size(), false);
    for (const auto& [view, shown] : background)
      for (const FaceRecord& record : shown) {
        balance[record.face] += record.is_mixed() ? -1 : 1;
        if (!record.is_mixed()) found[record.face] = true;
      }
    for (std::size_t f = 0; f < found.size(); ++f) found[f] = found[f] && balance[f] >= 0;
    for (const auto& [view, records] : by_view)
      for (const FaceRecord& record : records) found[record.face] = false;
    return found;
  }

  void compare_views(std::span<const double> log2_gain, const Grouped<std::uint32_t>& beside) {
    const Cells cells = make_cells(by_view, {log2_gain, view_count(by_view)}, beside);
    const bool quality_is_of_detail = options.term == DataTerm::gmi || options.term == DataTerm::gmi_angle;
    if (!quality_is_of_detail) discount_blurred(by_view, cells);
    find_outliers(by_view, log2_gain, beside, photo_of_view);
    judge_cells(by_view, cells, photo_of_view);
  }

  /// Where views are not compared, none disagrees.
  void forget_steps() {
    for (auto& [view, records] : by_view)
      for (FaceRecord& record : records) record.disagreement = 0;
  }

  /// \param graph null: made here
  const Grouped<std::uint32_t>& group(const FaceGraph* graph) {
    if (neighbours) return *neighbours;
    if (graph == nullptr) return neighbours.emplace(group_neighbours(mesh.faces.size(), face_graph(mesh).edges));
    return neighbours.emplace(group_neighbours(mesh.faces.size(), graph->edges));
  }
};

CandidateCollector::CandidateCollector(const Mesh& mesh, const CostOptions& options, std::vector<std::uint8_t> wanted)
    : state_(new State{mesh, options, std::move(wanted), {}}) {
  if (!state_->wanted.empty() && state_->wanted.size() != mesh.faces.size())
    throw std::invalid_argument("CandidateCollector: expected a flag per face, or none");
}
CandidateCollector::~CandidateCollector() = default;

void CandidateCollector::add_view(ViewId id, const View& view, const Image& photo,
                                  const visibility::ViewVisibility& visibility) {
  state_->add(
      id, view_statistics(state_->mesh, view, photo, visibility, state_->options, *state_->scratch, state_->wanted));
}

std::vector<std::byte> CandidateCollector::statistics_of(ViewId id) const {
  const auto view = static_cast<std::uint32_t>(index(id));
  const auto records = state_->by_view.find(view);
  if (records == state_->by_view.end()) return {};
  std::vector<FaceRecord> all = records->second;
  if (const auto shown = state_->background.find(view); shown != state_->background.end()) {
    const auto seen = static_cast<std::ptrdiff_t>(all.size());
    all.insert(all.end(), shown->second.begin(), shown->second.end());
    std::inplace_merge(all.begin(), all.begin() + seen, all.end(),
                       [](const FaceRecord& a, const FaceRecord& b) { return a.face < b.face; });
  }
  const auto bytes = std::as_bytes(std::span(all));
  return {bytes.begin(), bytes.end()};
}

void CandidateCollector::forget(ViewId id) {
  state_->by_view.erase(static_cast<std::uint32_t>(index(id)));
  state_->background.erase(static_cast<std::uint32_t>(index(id)));
}

double CandidateCollector::judging_bytes() const {
  double records = 0, full = 0, pixels = 0;
  for (const auto& [view, of_view] : state_->by_view) {
    records += static_cast<double>(of_view.capacity());
    for (const FaceRecord& record : of_view) {
      if (!record.is_full()) continue;
      full += 1;
      pixels += record.pixels;
    }
  }
  return static_cast<double>(sizeof(FaceRecord)) * records +
         labeling::judging_bytes(full, pixels, static_cast<double>(state_->mesh.faces.size()));
}

bool is_sound(std::span<const std::byte> statistics, std::size_t faces) {
  if (statistics.size() % sizeof(FaceRecord) != 0) return false;
  std::size_t next = 0;
  for (FaceRecord record; !statistics.empty(); statistics = statistics.subspan(sizeof record)) {
    std::memcpy(&record, statistics.data(), sizeof record);
    if (record.face < next || record.face >= faces || !(record.quality >= 0 && std::isfinite(record.quality)))
      return false;
    next = std::size_t{record.face} + 1;
  }
  return true;
}

bool CandidateCollector::add_statistics(ViewId id, std::span<const std::byte> statistics) {
  if (!is_sound(statistics, state_->mesh.faces.size())) return false;
  std::vector<FaceRecord> records(statistics.size() / sizeof(FaceRecord));
  if (!records.empty()) std::memcpy(records.data(), statistics.data(), statistics.size());
  state_->add(id, std::move(records));
  return true;
}

void CandidateCollector::set_photos(std::vector<std::uint32_t> photo_of_view) {
  state_->photo_of_view = std::move(photo_of_view);
}

void CandidateCollector::judge(const FaceGraph* graph) { judge_faces(judge_photos(graph), graph); }

PhotoJudgement CandidateCollector::judge_photos(const FaceGraph* graph) {
  RecordsByView& by_view = state_->by_view;
  leave_out_background(by_view, state_->background, state_->mesh.faces.size());
  state_->scratch.reset();
  PhotoJudgement photos{measure_agreement(by_view, state_->group(graph)), {}};
  leave_out(photos.agreement);
  if (state_->options.outliers != Outliers::none) photos.log2_gain = photo_gains(by_view, state_->mesh.faces.size());
  return photos;
}

void CandidateCollector::judge_faces(const PhotoJudgement& photos, const FaceGraph* graph) {
  leave_out_background(state_->by_view, state_->background, state_->mesh.faces.size());
  leave_out(photos.agreement);
  if (state_->options.outliers != Outliers::none)
    state_->compare_views(photos.log2_gain, state_->group(graph));
  else
    state_->forget_steps();
  take_judgement(photos.agreement);
}

void CandidateCollector::leave_out(std::span<const ViewAgreement> agreement) {
  if (state_->options.keep_odd_views || mostly_by_chance(agreement)) return;
  for (const ViewAgreement& each : agreement)
    if (each.by_chance) forget(each.view);
}

void CandidateCollector::take_judgement(std::vector<ViewAgreement> agreement) {
  state_->scratch.reset();
  state_->neighbours.reset();
  state_->agreement = std::move(agreement);
}

const std::vector<ViewAgreement>& CandidateCollector::agreement() const { return state_->agreement.value(); }

Candidates CandidateCollector::candidates(const Allowed& allowed) const {
  const std::vector<bool> background = state_->background_faces();
  auto parts = table_parts(state_->by_view, state_->mesh.faces.size(), state_->options, allowed);
  Candidates result = joined(parts, state_->mesh.faces.size());
  tag_background(background, result);
  result.agreement = agreement();
  return result;
}

Candidates CandidateCollector::finish(const FaceGraph* graph, const Allowed& allowed) {
  if (!state_->agreement) judge(graph);
  const std::vector<bool> background = state_->background_faces();
  auto parts = table_parts(state_->by_view, state_->mesh.faces.size(), state_->options, allowed);
  // Of all that is known of the views, the table holds the rest: less than half as much.
  state_->by_view.clear();
  release_freed_memory();
  Candidates result = joined(parts, state_->mesh.faces.size());
  tag_background(background, result);
  result.agreement = std::move(*state_->agreement);
  return result;
}

}  // namespace gpvc::labeling
