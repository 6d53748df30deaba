#include "labeling/costs/face_choice.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "labeling/costs/photo_consistency.h"

namespace gpvc::labeling {
namespace {

/// Halvings of quality from the face's best view to this one, as CostOptions::coarse_cost counts them.
double coarse_halvings(float quality, float best) {
  constexpr double kFree = 2, kMax = 2;
  if (!(best > 0)) return 0;
  if (!(quality > 0)) return kMax;
  return std::clamp(std::log2(static_cast<double>(best) / static_cast<double>(quality)) - kFree, 0.0, kMax);
}

/// Why a view with a surface is none of the candidates.
ViewFate fate_of(const FaceRecord& record, const CostOptions& options) {
  return options.outliers == Outliers::clamp && is_outlier(record) ? ViewFate::outlier : ViewFate::not_needed;
}

}  // namespace

bool is_outlier(const FaceRecord& record) { return record.disagreement > fixed_distance(kOutlierMeanDistance); }

void choose(std::span<const ViewRecord> records, const CostOptions& options, FaceChoice& choice) {
  choice.taken.clear();
  choice.quality.clear();
  choice.tag = FaceTag::unseen;
  const auto full = [](const ViewRecord& item) { return item.record->is_full(); };
  const auto kept = [&](const ViewRecord& item) {
    return options.outliers != Outliers::clamp || !is_outlier(*item.record);
  };
  const auto full_kept = [&](const ViewRecord& item) { return full(item) && kept(item); };
  const auto partial_kept = [&](const ViewRecord& item) { return !full(item) && kept(item); };
  const auto take = [&](FaceTag tag, const auto& wanted) {
    for (const ViewRecord& item : records) {
      if (!wanted(item)) continue;
      const double distance = distance_from_fixed(item.record->disagreement);
      const double agreement = options.outliers == Outliers::damp ? std::exp(-distance * distance / 2) : 1.0;
      choice.taken.push_back(item);
      choice.quality.push_back(static_cast<float>(static_cast<double>(item.record->quality) * agreement));
    }
    if (!choice.taken.empty()) choice.tag = tag;
    return !choice.taken.empty();
  };
  choice.rejected = records.size() - static_cast<std::size_t>(std::ranges::count_if(records, kept));

  // If all full views have the face entirely within the strip along silhouettes, partial views that have most of it
  // outside are preferred.
  const bool full_outside = std::ranges::any_of(
      records, [&](const ViewRecord& item) { return full_kept(item) && item.record->margin != kWholeShare; });
  const bool partial_clear = std::ranges::any_of(
      records, [&](const ViewRecord& item) { return partial_kept(item) && item.record->margin < kWholeShare / 2; });
  if ((full_outside || !partial_clear) && take(FaceTag::seen, full_kept)) return;
  if (take(FaceTag::partial, partial_kept)) return;
  // All views are rejected, but a doubtful photo is better than none.
  choice.rejected = 0;
  if (!take(FaceTag::seen, full)) take(FaceTag::partial, [](const ViewRecord&) { return true; });
}

CostParts cost_of(const FaceRecord& record, float quality, float best, const CostOptions& options) {
  const double share = best > 0 ? static_cast<double>(quality) / static_cast<double>(best) : 1;
  return {options.data_weight * (1 - share), options.margin_cost * record.margin / kWholeShare,
          options.hidden_cost * (kWholeShare - record.visible) / kWholeShare,
          options.coarse_cost * coarse_halvings(quality, best)};
}

std::vector<ViewChoice> choose_views(std::span<const ViewOfFace> views, const CostOptions& options,
                                     const std::function<bool(ViewId)>& allowed) {
  std::vector<ViewChoice> choices(views.size());
  std::vector<FaceRecord> records;
  std::vector<ViewRecord> left;
  records.reserve(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    records.push_back(views[v].record);
    if (!records[v].has_surface())
      choices[v].fate = records[v].is_mixed() ? ViewFate::mixed : ViewFate::background;
    else if (allowed && !allowed(views[v].view))
      choices[v].fate = ViewFate::refused;
    else
      left.push_back({static_cast<std::uint32_t>(v), &records[v]});
  }
  FaceChoice choice;
  choose(left, options, choice);
  for (const ViewRecord& item : left) choices[item.view].fate = fate_of(*item.record, options);
  const float best = choice.quality.empty() ? 0 : *std::ranges::max_element(choice.quality);
  for (std::size_t i = 0; i < choice.taken.size(); ++i)
    choices[choice.taken[i].view] = {ViewFate::candidate,
                                     cost_of(*choice.taken[i].record, choice.quality[i], best, options),
                                     fate_of(*choice.taken[i].record, options) == ViewFate::outlier};
  return choices;
}

std::optional<FaceRecord> record_of(std::span<const std::byte> statistics, FaceId face) {
  const auto record_at = [&](std::size_t n) {
    FaceRecord record;
    std::memcpy(&record, statistics.data() + n * sizeof record, sizeof record);
    return record;
  };
  std::size_t first = 0, end = statistics.size() / sizeof(FaceRecord);
  while (first < end) {
    const std::size_t middle = first + (end - first) / 2;
    const FaceRecord record = record_at(middle);
    if (record.face == index(face)) return record;
    if (record.face < index(face))
      first = middle + 1;
    else
      end = middle;
  }
  return std::nullopt;
}

}  // namespace gpvc::labeling
