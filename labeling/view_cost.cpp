// From statistics per face and view to candidates with costs: outliers out, full views before partial ones,
// qualities made comparable.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <map>

#include "labeling/labeling.h"
#include "labeling/photo_consistency.h"
#include "labeling/view_statistics.h"

namespace gpvc {
namespace {

using RecordsByView = std::map<std::uint32_t, std::vector<FaceRecord>>;

struct ViewRecord {
  std::uint32_t view;
  const FaceRecord* record;
};

/// Faces are worked through in chunks, so that nothing but the result is held for all of them by face.
constexpr std::size_t kChunkFaces = 16384;

/// The records of a range of faces, grouped by face, views ascending.
class FaceChunk {
 public:
  FaceChunk(const RecordsByView& by_view, std::size_t begin_face, std::size_t end_face)
      : begin_face_(begin_face), first_(end_face - begin_face + 1, 0) {
    std::vector<std::pair<std::uint32_t, std::span<const FaceRecord>>> parts;
    const auto before = [](const FaceRecord& record, std::size_t face) { return record.face < face; };
    for (const auto& [view, records] : by_view) {
      const auto begin = std::lower_bound(records.begin(), records.end(), begin_face, before);
      const auto end = std::lower_bound(begin, records.end(), end_face, before);
      if (begin != end) parts.emplace_back(view, std::span<const FaceRecord>(begin, end));
    }
    for (const auto& [view, records] : parts)
      for (const FaceRecord& record : records) ++first_[record.face - begin_face_ + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    records_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const auto& [view, records] : parts)
      for (const FaceRecord& record : records) records_[next[record.face - begin_face_]++] = {view, &record};
  }

  std::span<const ViewRecord> of(std::size_t face) const {
    const std::size_t i = face - begin_face_;
    return {records_.data() + first_[i], first_[i + 1] - first_[i]};
  }

 private:
  std::size_t begin_face_;
  std::vector<std::size_t> first_;
  std::vector<ViewRecord> records_;
};

/// Calls body(chunk index, first face, one past the last) for all chunks, in parallel.
template <class Body>
void for_each_chunk(std::size_t faces, Body body) {
  const std::size_t chunks = (faces + kChunkFaces - 1) / kChunkFaces;
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    body(chunk, chunk * kChunkFaces, std::min(faces, (chunk + 1) * kChunkFaces));
  });
}

// --- exposure ---------------------------------------------------------------------------------------------

/// Per view and channel, the factor that photo's colours are to be divided by.
class PhotoGains {
 public:
  explicit PhotoGains(std::size_t views) : log2_gain_(views * 3, 0.0) {}

  ColourSample sample(const ViewRecord& item) const {
    ColourSample result;
    for (std::size_t c = 0; c < 3; ++c)
      result.rgb[c] =
          static_cast<float>(item.record->colour[c] / 256.0 * std::exp2(-log2_gain_[item.view * 3 + c]));
    return result;
  }

  /// One round: every face compares its photos with their median; a photo's gain is the median of its ratios.
  /// Only histograms are shared, so the order of faces is of no account.
  void refine(const RecordsByView& by_view, std::size_t faces) {
    std::vector<std::uint32_t> histogram(log2_gain_.size() * kBins, 0);
    // 64 chunks are plenty of faces (1 M) to take medians from.
    const std::size_t chunks = (faces + kChunkFaces - 1) / kChunkFaces, stride = chunks / 64 + 1;
    for_each_chunk(faces, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      if (chunk % stride != 0) return;
      const FaceChunk grouped(by_view, begin, end);
      for (std::size_t face = begin; face != end; ++face) compare(grouped.of(face), histogram);
    });
    for (std::size_t i = 0; i < log2_gain_.size(); ++i)
      log2_gain_[i] += median_bin({histogram.data() + i * kBins, kBins});
  }

 private:
  static constexpr std::size_t kBins = 512;  ///< of 1/64 f-stop (1 %), from -4 to +4
  static constexpr double kBinsPerStop = 64;
  static constexpr float kDark = 8;  ///< grey levels below which a ratio says little

  void compare(std::span<const ViewRecord> records, std::vector<std::uint32_t>& histogram) const {
    if (records.size() < 3) return;
    std::vector<ColourSample> samples;
    for (const ViewRecord& item : records) samples.push_back(sample(item));
    std::vector<float> channel(samples.size());
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < samples.size(); ++i) channel[i] = samples[i].rgb[c];
      const auto middle = channel.begin() + static_cast<std::ptrdiff_t>(channel.size() / 2);
      std::nth_element(channel.begin(), middle, channel.end());
      if (*middle < kDark) continue;
      for (std::size_t i = 0; i < samples.size(); ++i) {
        if (samples[i].rgb[c] < kDark) continue;
        const double stops = std::log2(static_cast<double>(samples[i].rgb[c]) / static_cast<double>(*middle));
        const double bin = std::clamp(stops * kBinsPerStop + kBins / 2.0, 0.0, kBins - 1.0);
        std::atomic_ref<std::uint32_t>(
            histogram[(records[i].view * 3 + c) * kBins + static_cast<std::size_t>(bin)])
            .fetch_add(1, std::memory_order_relaxed);
      }
    }
  }

  static double median_bin(std::span<const std::uint32_t> bins) {
    std::uint64_t total = 0, sum = 0;
    for (const std::uint32_t count : bins) total += count;
    if (total == 0) return 0;
    std::size_t bin = 0;
    while (2 * (sum + bins[bin]) < total) sum += bins[bin++];
    // Ratios of exactly one sit at the lower edge of the middle bin; the position within a bin tells them
    // apart.
    const double within = (static_cast<double>(total) / 2 - static_cast<double>(sum)) / bins[bin];
    const double edge = (static_cast<double>(bin) - kBins / 2.0) / kBinsPerStop;
    return bin == kBins / 2 ? 0.0 : edge + within / kBinsPerStop;
  }

  std::vector<double> log2_gain_;
};

// --- choice
// ---------------------------------------------------------------------------------------------------

/// What one face may choose from, before qualities are made comparable.
struct Choice {
  std::vector<ViewRecord> taken;
  std::vector<float> quality;  ///< of those taken
  FaceTag tag = FaceTag::filled;
  std::size_t rejected = 0;
};

class Chooser {
 public:
  Chooser(const CostOptions& options, const PhotoGains& gains) : options_(options), gains_(gains) {}

  const Choice& choose(std::span<const ViewRecord> records) {
    choice_ = {};
    judge(records);
    const auto take = [&](auto wanted) {
      for (std::size_t i = 0; i < records.size(); ++i)
        if (wanted(i)) add(records[i], agreement_[i]);
      return !choice_.taken.empty();
    };
    const auto full = [&](std::size_t i) { return records[i].record->is_full(); };
    const auto kept = [&](std::size_t i) { return !rejected(i); };
    const auto clear = [&](std::size_t i) { return records[i].record->margin < kWholeShare / 2; };
    const auto in_strip = [&](std::size_t i) { return records[i].record->margin == kWholeShare; };

    // Full views that lie in a silhouette's strip as a whole give way to partial ones that mostly do not.
    bool full_outside = false, partial_clear = false;
    for (std::size_t i = 0; i < records.size(); ++i) {
      full_outside |= full(i) && kept(i) && !in_strip(i);
      partial_clear |= !full(i) && kept(i) && clear(i);
    }
    if (full_outside || !partial_clear)
      if (take([&](std::size_t i) { return full(i) && kept(i); })) return finish(FaceTag::seen);
    if (take([&](std::size_t i) { return !full(i) && kept(i); })) return finish(FaceTag::partial);
    // All rejected: a doubtful photo is better than none.
    choice_.rejected = 0;
    if (take(full)) return finish(FaceTag::seen);
    if (take([&](std::size_t) { return true; })) return finish(FaceTag::partial);
    return choice_;
  }

 private:
  void judge(std::span<const ViewRecord> records) {
    agreement_.assign(records.size(), 1.0f);
    if (options_.outliers == Outliers::none || records.size() < 3) return;
    samples_.clear();
    std::size_t full = 0;
    for (const ViewRecord& item : records) full += item.record->is_full();
    for (const ViewRecord& item : records) {
      samples_.push_back(gains_.sample(item));
      samples_.back().votes = full < 3 || item.record->is_full();
    }
    agreement(samples_, agreement_);
    if (options_.outliers == Outliers::clamp)
      for (std::size_t i = 0; i < records.size(); ++i) choice_.rejected += rejected(i);
  }

  bool rejected(std::size_t i) const {
    return options_.outliers == Outliers::clamp && agreement_[i] < kOutlierBelow;
  }

  void add(const ViewRecord& item, float agrees) {
    choice_.taken.push_back(item);
    choice_.quality.push_back(options_.outliers == Outliers::damp ? item.record->quality * agrees
                                                                  : item.record->quality);
  }

  const Choice& finish(FaceTag tag) {
    choice_.tag = tag;
    return choice_;
  }

  const CostOptions& options_;
  const PhotoGains& gains_;
  Choice choice_;
  std::vector<ColourSample> samples_;
  std::vector<float> agreement_;
};

// --- costs -----------------------------------------------------------------------------------------------

/// The value that a share `quantile` of the values (>= 0) does not exceed. Bits of non-negative floats ascend
/// with them, so two histograms of 16 bits each find it exactly and without a sorted copy.
float quantile_of(const std::vector<float>& values, double quantile) {
  if (values.empty()) return 0;
  auto rank = static_cast<std::uint64_t>(quantile * static_cast<double>(values.size() - 1));
  std::vector<std::uint64_t> bins(65536, 0);
  const auto find = [&] {
    std::uint32_t bin = 0;
    while (rank >= bins[bin]) rank -= bins[bin++];
    return bin;
  };
  for (const float value : values) ++bins[std::bit_cast<std::uint32_t>(value) >> 16];
  const std::uint32_t high = find();
  bins.assign(65536, 0);
  for (const float value : values)
    if (const auto bits = std::bit_cast<std::uint32_t>(value); bits >> 16 == high) ++bins[bits & 0xFFFFu];
  return std::bit_cast<float>(high << 16 | find());
}

/// A chunk's part of the table.
struct TablePart {
  std::vector<std::uint32_t> views;
  std::vector<float> quality, penalty;
  std::vector<std::uint32_t> counts;  ///< per face
  std::vector<FaceTag> tags;
  std::size_t full = 0, partial = 0, rejected = 0;

  void add(const Choice& choice, const CostOptions& options) {
    counts.push_back(static_cast<std::uint32_t>(choice.taken.size()));
    tags.push_back(choice.tag);
    rejected += choice.rejected;
    for (std::size_t i = 0; i < choice.taken.size(); ++i) {
      const FaceRecord& record = *choice.taken[i].record;
      (record.is_full() ? full : partial) += 1;
      views.push_back(choice.taken[i].view);
      quality.push_back(choice.quality[i]);
      penalty.push_back(
          static_cast<float>(options.margin_cost * record.margin / kWholeShare +
                             options.hidden_cost * (kWholeShare - record.visible) / kWholeShare));
    }
  }
};

}  // namespace

struct CandidateCollector::State {
  const Mesh& mesh;
  CostOptions options;
  RecordsByView by_view;
};

CandidateCollector::CandidateCollector(const Mesh& mesh, const CostOptions& options)
    : state_(new State{mesh, options, {}}) {}
CandidateCollector::~CandidateCollector() = default;

void CandidateCollector::add_view(ViewId id, const View& view, const Image& photo,
                                  const ViewVisibility& visibility) {
  state_->by_view[static_cast<std::uint32_t>(id)] =
      view_statistics(state_->mesh, view, photo, visibility, state_->options);
}

Candidates CandidateCollector::finish() {
  const CostOptions& options = state_->options;
  const RecordsByView& by_view = state_->by_view;
  const std::size_t faces = state_->mesh.faces.size();
  PhotoGains gains(by_view.empty() ? 0 : std::size_t{by_view.rbegin()->first} + 1);
  if (options.outliers != Outliers::none)
    for (int round = 0; round < 2; ++round) gains.refine(by_view, faces);

  std::vector<TablePart> parts((faces + kChunkFaces - 1) / kChunkFaces);
  for_each_chunk(faces, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    const FaceChunk grouped(by_view, begin, end);
    Chooser chooser(options, gains);
    for (std::size_t face = begin; face != end; ++face)
      parts[chunk].add(chooser.choose(grouped.of(face)), options);
  });
  state_->by_view.clear();

  Candidates result;
  std::vector<float> penalty;
  result.table.first.reserve(faces + 1);
  result.table.first.push_back(0);
  for (TablePart& part : parts) {
    for (const std::uint32_t count : part.counts)
      result.table.first.push_back(result.table.first.back() + count);
    result.table.views.insert(result.table.views.end(), part.views.begin(), part.views.end());
    result.table.costs.insert(result.table.costs.end(), part.quality.begin(), part.quality.end());
    penalty.insert(penalty.end(), part.penalty.begin(), part.penalty.end());
    result.tags.insert(result.tags.end(), part.tags.begin(), part.tags.end());
    result.full += part.full;
    result.partial += part.partial;
    result.rejected += part.rejected;
    part = {};
  }
  // Costs in [0, 1] before penalties. A few huge faces must not flatten all others: the best half per cent
  // count alike (Waechter et al. 2014 normalize so, too).
  const float best = quantile_of(result.table.costs, 0.995);
  for (std::size_t i = 0; i < penalty.size(); ++i) {
    const float quality = best > 0 ? std::min(1.0f, result.table.costs[i] / best) : 1.0f;
    result.table.costs[i] = 1.0f - quality + penalty[i];
  }
  return result;
}

}  // namespace gpvc
