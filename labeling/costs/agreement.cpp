// How well each photo agrees with the others about what the mesh looks like.
#include "labeling/costs/agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "io/order_statistics.h"

namespace gpvc::labeling {
namespace {

/// Places with which a view is compared for chance.
constexpr std::size_t kElsewhere = 8;
/// Correlations scatter by the root of one over the number of steps: by 0.022 with many, by 0.05 with few, which tell only
/// what is clear: a photo that agrees by more than chance, or by less than chance does on the average.
constexpr std::size_t kManySteps = 2000, kFewSteps = 400;
/// Edges between the two faces of a step: far enough that misregistration by a pixel or two does not hide it.
constexpr int kReach = 3;

/// Sums for the correlation of a view's steps with those of the others: at the same places, and elsewhere.
struct Sums {
  double own2 = 0, others2 = 0;
  std::array<double, 1 + kElsewhere> products{};
  std::size_t steps = 0;

  void add(const Sums& s) {
    own2 += s.own2;
    others2 += s.others2;
    for (std::size_t k = 0; k < products.size(); ++k) products[k] += s.products[k];
    steps += s.steps;
  }
};

/// A view's step in brightness, and the mean of those that other views see there.
struct Step {
  float own, others;
};

/// Logarithm of the brightness; noise of dark surfaces is damped.
float log_brightness(const FaceRecord& record) {
  constexpr float kDark = 16 * 256 * 3;  // 16 grey levels, in the records' units
  const int sum = record.color[0] + record.color[1] + record.color[2];
  return std::log(static_cast<float>(sum) + kDark);
}

/// The face some edges away from a face, always in another direction than back.
std::uint32_t face_nearby(const Grouped<std::uint32_t>& neighbours, std::uint32_t face) {
  std::uint32_t before = face;
  for (int k = 0; k < kReach; ++k) {
    const auto beside = neighbours[face];
    if (beside.empty()) return face;
    const std::uint32_t at = beside[(face + static_cast<std::uint32_t>(k)) % beside.size()];
    const std::uint32_t next = at == before ? beside[(face + static_cast<std::uint32_t>(k) + 1) % beside.size()] : at;
    before = std::exchange(face, next);
  }
  return face;
}

ViewAgreement judge(ViewId view, const Sums& sums) {
  // Photos at the poses of their neighbours correlate by up to 0.03, because roads or windows run on in the same
  // direction; right ones by 0.3 and more, even of trees in the wind, and by 0.11 at least where only two or three overlap
  // a little (measured on three scenes from photos).
  constexpr double kLeast = 0.05, kChances = 3;
  ViewAgreement result{view, sums.steps};
  const double norm = std::sqrt(sums.own2 * sums.others2);
  if (sums.steps < kFewSteps || !(norm > 0)) return result;
  result.correlation = sums.products[0] / norm;
  double chance2 = 0;
  for (std::size_t k = 1; k <= kElsewhere; ++k) chance2 += sums.products[k] * sums.products[k];
  result.chance = std::sqrt(chance2 / kElsewhere) / norm;
  const bool agrees = result.correlation >= std::max(kLeast, kChances * result.chance);
  result.judged = sums.steps >= kManySteps || agrees || result.correlation < result.chance;
  result.by_chance = result.judged && !agrees;
  return result;
}

/// Photos that are turned, or at other poses, may agree by more than chance, as streets and walls run on in the same
/// directions, and few steps cannot tell such a photo from chance: but the others agree far better.
void compare_with_median(std::vector<ViewAgreement>& views) {
  constexpr std::size_t kLeastViews = 3;
  constexpr double kLeastShare = 0.25;
  std::vector<double> correlations;
  for (const ViewAgreement& each : views)
    if (each.steps >= kFewSteps) correlations.push_back(each.correlation);
  if (correlations.size() < kLeastViews) return;
  const double least = kLeastShare * upper_median(std::span(correlations));
  for (ViewAgreement& each : views)
    if (each.steps >= kFewSteps && each.correlation < least) each.judged = each.by_chance = true;
}

/// The steps of a chunk of faces, by view.
class ChunkSteps {
 public:
  /// \param left_out per view, 1 for those that are compared with the others, but not they with it
  explicit ChunkSteps(std::span<const std::uint8_t> left_out) : steps_(left_out.size()), left_out_(left_out) {}

  void add(std::span<const ViewRecord> here, std::span<const ViewRecord> there) {
    seen_.clear();
    double sum = 0;
    std::size_t voting = 0;
    auto other = there.begin();
    for (const ViewRecord& item : here) {
      while (other != there.end() && other->view < item.view) ++other;
      if (other == there.end()) break;
      if (other->view != item.view || !item.record->is_full() || !other->record->is_full()) continue;
      const float step = std::clamp(log_brightness(*other->record) - log_brightness(*item.record), -1.0f, 1.0f);
      seen_.emplace_back(item.view, step);
      if (left_out_[item.view] != 0) continue;
      sum += static_cast<double>(step);
      ++voting;
    }
    for (const auto& [view, step] : seen_) {
      const bool votes = left_out_[view] == 0;
      const std::size_t others = voting - (votes ? 1 : 0);
      if (others == 0) continue;
      const double rest = sum - (votes ? static_cast<double>(step) : 0);
      steps_[view].push_back({step, static_cast<float>(rest / static_cast<double>(others))});
    }
  }

  Sums sums_of(std::size_t view) const {
    const std::vector<Step>& steps = steps_[view];
    Sums sums;
    if (steps.size() < 8 * kElsewhere) return sums;
    sums.steps = steps.size();
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const auto own = static_cast<double>(steps[i].own);
      sums.own2 += own * own;
      sums.others2 += static_cast<double>(steps[i].others) * static_cast<double>(steps[i].others);
      for (std::size_t k = 0; k <= kElsewhere; ++k)
        sums.products[k] +=
            own * static_cast<double>(steps[(i + k * steps.size() / (kElsewhere + 1)) % steps.size()].others);
    }
    return sums;
  }

 private:
  std::vector<std::vector<Step>> steps_;
  std::span<const std::uint8_t> left_out_;
  std::vector<std::pair<std::uint32_t, float>> seen_;
};

/// Correlations by view; views that are left out do not count among the others.
std::vector<ViewAgreement> correlate(RecordsByView& by_view, const Grouped<std::uint32_t>& neighbours,
                                     std::span<const std::uint8_t> left_out) {
  const std::size_t faces = neighbours.groups(), stride = chunk_count(faces) / 64 + 1;
  std::vector<std::vector<Sums>> of_chunks(chunk_count(faces));
  for_each_chunk(by_view, faces, stride, [&](std::size_t chunk, const Grouped<ViewRecord>& records) {
    ChunkSteps steps(left_out);
    const std::size_t begin = chunk * kChunkFaces;
    for (std::size_t f = 0; f < records.groups(); ++f) {
      const std::size_t other = face_nearby(neighbours, static_cast<std::uint32_t>(begin + f)) - begin;
      if (other != f && other < records.groups()) steps.add(records[f], records[other]);
    }
    for (std::size_t v = 0; v < left_out.size(); ++v) of_chunks[chunk].push_back(steps.sums_of(v));
  });
  std::vector<ViewAgreement> result;
  for (const auto& [view, records] : by_view) {
    Sums sums;
    for (const std::vector<Sums>& chunk : of_chunks)
      if (!chunk.empty()) sums.add(chunk[view]);
    result.push_back(judge(ViewId{view}, sums));
  }
  compare_with_median(result);
  return result;
}

}  // namespace

std::vector<ViewAgreement> measure_agreement(RecordsByView& by_view, const Grouped<std::uint32_t>& neighbours) {
  if (by_view.empty()) return {};
  std::vector<std::uint8_t> left_out(std::size_t{by_view.rbegin()->first} + 1, 0);
  std::vector<ViewAgreement> result = correlate(by_view, neighbours, left_out);
  // Those that see little but what wrong views see are judged again without these.
  for (const ViewAgreement& each : result) left_out[index(each.view)] = each.by_chance ? 1 : 0;
  const bool some = std::ranges::find(left_out, 1) != left_out.end();
  return some && !mostly_by_chance(result) ? correlate(by_view, neighbours, left_out) : result;
}

bool mostly_by_chance(std::span<const ViewAgreement> agreement) {
  return std::ranges::count(agreement, true, &ViewAgreement::by_chance) * 2 >
         std::ranges::count(agreement, true, &ViewAgreement::judged);
}

}  // namespace gpvc::labeling
