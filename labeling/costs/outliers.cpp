#include "labeling/costs/outliers.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <functional>
#include <utility>

#include "io/order_statistics.h"
#include "labeling/costs/photo_colors.h"
#include "labeling/costs/photo_consistency.h"

namespace gpvc::labeling {
namespace {

/// Bins of 1/64 f-stop (1 %), from -4 to +4.
constexpr int kBinsPerStop = 64;
constexpr int kBins = 8 * kBinsPerStop;

/// Finds the bin of a ratio, floor(64 log2(ratio)) + 256, with a table in place of the logarithm.
///
/// A ratio is f 2^e with 1 <= f < 2. The first eight bits of f after the point give one of 256 intervals; bins are wider
/// than those, so an interval contains at most one edge of a bin.
class RatioBins {
 public:
  RatioBins() {
    for (std::size_t i = 0; i < kIntervals; ++i) {
      const double begin = 1 + static_cast<double>(i) / kIntervals;
      first_[i] = static_cast<std::int32_t>(std::log2(begin) * kBinsPerStop);
      edge_[i] = std::exp2((first_[i] + 1.0) / kBinsPerStop);
    }
  }
  /// \pre ratio > 0, normal. Ratios beyond the bins count in the first or the last one.
  std::size_t of(double ratio) const {
    constexpr std::uint64_t kFraction = (std::uint64_t{1} << 52) - 1;
    const auto bits = std::bit_cast<std::uint64_t>(ratio);
    const double f = std::bit_cast<double>((bits & kFraction) | std::bit_cast<std::uint64_t>(1.0));
    const auto interval = static_cast<std::size_t>((bits & kFraction) >> 44);
    const std::int32_t exponent = static_cast<std::int32_t>(bits >> 52) - 1023;
    const std::int32_t bin = kBins / 2 + exponent * kBinsPerStop + first_[interval] + (f >= edge_[interval] ? 1 : 0);
    return static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1));
  }

 private:
  static constexpr std::size_t kIntervals = 256;
  std::array<std::int32_t, kIntervals> first_{};  ///< the bin of the interval's begin
  std::array<double, kIntervals> edge_{};         ///< where the next bin begins
};

/// Per view and channel, the gain of the photo: the factor by which its colours are to be divided.
class PhotoGains {
 public:
  explicit PhotoGains(std::size_t views) : colors_({}, views) {}
  const std::vector<double>& log2() const { return colors_.log2_gain(); }

  /// One round: every face compares its photos with their median; a photo's gain is the median of its ratios. Counts
  /// do not depend on the order of the faces.
  void refine(RecordsByView& by_view, std::size_t faces) {
    const std::size_t gains = log2().size();
    const Histogram empty(gains * kBins, 0);
    tbb::enumerable_thread_specific<Histogram> of_threads(empty);
    // Some faces suffice: the median of 1000 ratios that scatter by 10 % is known to half a per cent, half a bin, and of so
    // many faces all over the mesh a photo that is of use shows more. They are the n-th ones of some chunks.
    constexpr std::size_t kChunks = 64, kFaces = 262144;
    const std::size_t chunk_stride = chunk_count(faces) / kChunks + 1;
    const std::size_t face_stride = faces / chunk_stride / kFaces + 1;
    for_each_chunk(by_view, faces, chunk_stride, [&](std::size_t, const Grouped<ViewRecord>& records) {
      Levels levels;
      Histogram& histogram = of_threads.local();
      for (std::size_t face = 0; face < records.groups(); face += face_stride)
        compare(records[face], levels, histogram);
    });
    Histogram histogram = empty;
    for (const Histogram& part : of_threads)
      std::transform(histogram.begin(), histogram.end(), part.begin(), histogram.begin(), std::plus<>());
    for (std::size_t i = 0; i < gains; ++i)
      colors_.set(i, log2()[i] + median_bin({histogram.data() + i * kBins, kBins}));
  }

 private:
  using Histogram = std::vector<std::uint32_t>;
  /// Work space: a channel of a face in its photos.
  struct Levels {
    std::vector<float> of_photos, ordered;
  };
  static constexpr float kDark = 8;  ///< grey levels below which noise dominates a ratio

  void compare(std::span<const ViewRecord> records, Levels& levels, Histogram& histogram) const {
    if (records.size() < 3) return;
    for (std::size_t c = 0; c < 3; ++c) {
      levels.of_photos.resize(records.size());
      for (std::size_t i = 0; i < records.size(); ++i)
        levels.of_photos[i] = colors_.level(records[i].view, *records[i].record, c);
      levels.ordered = levels.of_photos;
      const float middle = upper_median(std::span(levels.ordered));
      if (middle < kDark) continue;
      for (std::size_t i = 0; i < records.size(); ++i) {
        if (levels.of_photos[i] < kDark) continue;
        const double ratio = static_cast<double>(levels.of_photos[i]) / static_cast<double>(middle);
        ++histogram[(records[i].view * 3 + c) * kBins + bins_.of(ratio)];
      }
    }
  }

  static double median_bin(std::span<const std::uint32_t> bins) {
    std::uint64_t total = 0, sum = 0;
    for (const std::uint32_t count : bins) total += count;
    if (total == 0) return 0;
    std::size_t bin = 0;
    while (2 * (sum + bins[bin]) < total) sum += bins[bin++];
    // A ratio of exactly one lies on the lower edge of the middle bin, so a median in that bin counts as one.
    const double within = (static_cast<double>(total) / 2 - static_cast<double>(sum)) / bins[bin];
    const double edge = (static_cast<double>(bin) - kBins / 2.0) / kBinsPerStop;
    return bin == kBins / 2 ? 0.0 : edge + within / kBinsPerStop;
  }

  RatioBins bins_;
  PhotoColors colors_;
};

/// Rounds of averaging over a face and those it shares edges with; ten of them weigh some thirty faces. Chosen by the
/// error on held-out photos and by the number of patches: 0, 3 and 10 rounds leave 2801, 559 and 459 on a park with trees.
constexpr int kRounds = 10;

/// Work space of one thread.
struct FaceScratch {
  std::vector<ColorSample> samples;
  ConsensusScratch consensus;
  std::vector<double> distance;
};

/// True if a view before it shows the same photo. \pre views ascend
bool repeats_photo(std::span<const ViewRecord> records, std::size_t i, std::span<const std::uint32_t> photo_of_view) {
  if (photo_of_view.empty()) return false;
  const std::uint32_t photo = photo_of_view[records[i].view];
  return std::ranges::any_of(records.first(i),
                             [&](const ViewRecord& other) { return photo_of_view[other.view] == photo; });
}

/// True if a channel of the mean is white, but for noise.
bool is_burnt_out(const FaceRecord& record) {
  constexpr int kWhite = 250 * 256;
  return std::ranges::max(record.color) >= kWhite;
}

/// True if a photo that is not burnt out sees the face in full, and would be as bright if it had the other's gain: a darker photo, and
/// nothing that stands in front.
bool has_darker_photo(std::span<const ViewRecord> records, const ViewRecord& burnt_out, const PhotoColors& colors) {
  constexpr float kAsBright = 0.95f;  // gains are known to some per cent
  return std::ranges::any_of(records, [&](const ViewRecord& item) {
    if (!item.record->is_full() || is_burnt_out(*item.record)) return false;
    for (std::size_t c = 0; c < 3; ++c)
      if (colors.level(item.view, *item.record, c) < kAsBright * colors.level(burnt_out.view, *burnt_out.record, c))
        return false;
    return true;
  });
}

void measure_disagreement(std::span<const ViewRecord> records, const PhotoColors& colors,
                          std::span<const std::uint32_t> photo_of_view, FaceScratch& scratch) {
  const auto full =
      std::count_if(records.begin(), records.end(), [](const ViewRecord& item) { return item.record->is_full(); });
  std::vector<ColorSample>& samples = scratch.samples;
  samples.clear();
  for (std::size_t i = 0; i < records.size(); ++i) {
    FaceRecord& record = *records[i].record;
    // A burnt-out photo does not vote where a darker photo shows the face unclipped, and is chosen last.
    const bool lost = is_burnt_out(record) && has_darker_photo(records, records[i], colors);
    if (lost) record.quality = 0;
    samples.push_back({colors.rgb(records[i].view, record)});
    samples.back().votes = !lost && (full < 3 || record.is_full()) && !repeats_photo(records, i, photo_of_view);
  }
  disagreement(samples, scratch.consensus, scratch.distance);
  for (std::size_t i = 0; i < records.size(); ++i)
    records[i].record->disagreement = fixed_distance(std::min(scratch.distance[i], kMaxDistance));
}

constexpr std::uint32_t kNoRecord = 0xFFFFFFFFu;

/// Rounded quotients of sums by small counts. m = ceil(2^32 / count) is too large by less than 1, so for numbers below
/// 2^32 / count, as all sums of so many 16-bit values are, the upper half of the product with m is the quotient.
class Mean {
 public:
  /// Values in a mean: a face and at each of its edges the others that FaceGraph pairs it with.
  static constexpr std::size_t kMost = 1 + 3 * 2 * kFaceGraphReach;
  Mean() {
    for (std::size_t count = 1; count <= kMost; ++count)
      factor_[count] = ((std::uint64_t{1} << 32) + count - 1) / count;
  }
  std::uint16_t of(std::uint32_t sum, std::size_t count) const {
    return static_cast<std::uint16_t>((sum + count / 2) * factor_[count] >> 32);
  }

 private:
  std::array<std::uint64_t, kMost + 1> factor_{};
};

/// True if the face is an outlier by itself and touches the strip along silhouettes: the photo probably shows there what
/// lies on the other side of the edge. The rim that it shows is often a single face wide, so that the average over the
/// faces around would hide it.
bool shows_beyond_edge(const FaceRecord& record) {
  return record.margin > 0 && record.disagreement > fixed_distance(kOutlierDistance);
}

/// Averages over the faces of a view, and finds who is averaged with whom once for all rounds. Work space of one thread.
class Averager {
 public:
  void average(std::vector<FaceRecord>& records, const Grouped<std::uint32_t>& neighbours) {
    find_others(records, neighbours);
    here_.resize(records.size());
    before_.resize(records.size());
    for (std::size_t i = 0; i < records.size(); ++i) here_[i] = records[i].disagreement;
    for (int round = 0; round < kRounds; ++round) {
      here_.swap(before_);
      const std::uint32_t* other = others_.data();
      for (std::size_t i = 0; i < records.size(); ++i) {
        std::uint32_t sum = before_[i];
        const std::size_t count = counts_[i];
        for (std::size_t k = 0; k < count; ++k) sum += before_[other[k]];
        other += count;
        here_[i] = mean_.of(sum, count + 1);
      }
    }
    for (std::size_t i = 0; i < records.size(); ++i) {
      FaceRecord& record = records[i];
      record.disagreement = shows_beyond_edge(record) ? std::max(here_[i], record.disagreement) : here_[i];
    }
  }

 private:
  void find_others(const std::vector<FaceRecord>& records, const Grouped<std::uint32_t>& neighbours) {
    record_of_face_.resize(neighbours.groups(), kNoRecord);
    for (std::uint32_t i = 0; i < records.size(); ++i) record_of_face_[records[i].face] = i;
    others_.clear();
    counts_.clear();
    for (const FaceRecord& record : records) {
      const std::size_t before = others_.size();
      for (const std::uint32_t face : neighbours[record.face])
        if (const std::uint32_t other = record_of_face_[face]; other != kNoRecord) others_.push_back(other);
      counts_.push_back(static_cast<std::uint8_t>(others_.size() - before));
      assert(counts_.back() < Mean::kMost);
    }
    for (const FaceRecord& record : records) record_of_face_[record.face] = kNoRecord;
  }

  Mean mean_;
  std::vector<std::uint32_t> record_of_face_;  ///< kNoRecord for every face between views
  std::vector<std::uint32_t> others_;          ///< by record, the records of the faces beside it
  std::vector<std::uint8_t> counts_;           ///< by record, how many those are
  std::vector<std::uint16_t> here_, before_;   ///< by record
};

}  // namespace

std::vector<double> photo_gains(RecordsByView& by_view, std::size_t faces) {
  PhotoGains gains(view_count(by_view));
  for (int round = 0; round < 2; ++round) gains.refine(by_view, faces);
  return gains.log2();
}

void find_outliers(RecordsByView& by_view, std::span<const double> log2_gain, const Grouped<std::uint32_t>& neighbours,
                   std::span<const std::uint32_t> photo_of_view) {
  if (by_view.empty()) return;
  const PhotoColors colors(log2_gain, view_count(by_view));
  for_each_chunk(by_view, neighbours.groups(), 1, [&](std::size_t, const Grouped<ViewRecord>& records) {
    FaceScratch scratch;
    for (std::size_t face = 0; face < records.groups(); ++face)
      measure_disagreement(records[face], colors, photo_of_view, scratch);
  });
  std::vector<std::vector<FaceRecord>*> views;
  for (auto& [view, records] : by_view) views.push_back(&records);
  tbb::enumerable_thread_specific<Averager> averagers;
  tbb::parallel_for(std::size_t{0}, views.size(),
                    [&](std::size_t view) { averagers.local().average(*views[view], neighbours); });
}

}  // namespace gpvc::labeling
