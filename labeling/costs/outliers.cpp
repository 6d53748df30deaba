#include "labeling/costs/outliers.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "io/grouping.h"
#include "labeling/costs/photo_consistency.h"

namespace gpvc::labeling {
namespace {

/// Per view and channel, the gain of the photo: the factor by which its colours are to be divided.
class PhotoGains {
 public:
  explicit PhotoGains(std::size_t views) : log2_gain_(views * 3, 0.0), factor_(views * 3, 1.0) {}

  ColorSample sample(const ViewRecord& item) const {
    ColorSample result;
    for (std::size_t c = 0; c < 3; ++c)
      result.rgb[c] = static_cast<float>(item.record->color[c] / 256.0 * factor_[item.view * 3 + c]);
    return result;
  }

  /// One round: every face compares its photos with their median; a photo's gain is the median of its ratios. Counts
  /// do not depend on the order of the faces.
  void refine(RecordsByView& by_view, std::size_t faces) {
    using Histogram = std::vector<std::uint32_t>;
    const Histogram empty(log2_gain_.size() * kBins, 0);
    tbb::enumerable_thread_specific<Histogram> of_threads(empty);
    // The faces of 64 chunks (1 M) suffice for the medians.
    const std::size_t stride = chunk_count(faces) / 64 + 1;
    for_each_chunk(by_view, faces, stride, [&](std::size_t, const Grouped<ViewRecord>& records) {
      for (std::size_t face = 0; face < records.groups(); ++face) compare(records[face], of_threads.local());
    });
    Histogram histogram = empty;
    for (const Histogram& part : of_threads)
      std::transform(histogram.begin(), histogram.end(), part.begin(), histogram.begin(), std::plus<>());
    for (std::size_t i = 0; i < log2_gain_.size(); ++i) {
      log2_gain_[i] += median_bin({histogram.data() + i * kBins, kBins});
      factor_[i] = std::exp2(-log2_gain_[i]);
    }
  }

 private:
  static constexpr std::size_t kBins = 512;  ///< of 1/64 f-stop (1 %), from -4 to +4
  static constexpr double kBinsPerStop = 64;
  static constexpr float kDark = 8;  ///< grey levels below which noise dominates a ratio

  void compare(std::span<const ViewRecord> records, std::vector<std::uint32_t>& histogram) const {
    if (records.size() < 3) return;
    std::vector<ColorSample> samples;
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
        ++histogram[(records[i].view * 3 + c) * kBins + static_cast<std::size_t>(bin)];
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

  std::vector<double> log2_gain_;
  std::vector<double> factor_;  ///< 1 / gain, for colours
};

/// Rounds of averaging over a face and those it shares edges with; ten of them weigh some thirty faces. Chosen by the
/// error on held-out photos and by the number of patches: 0, 3 and 10 rounds leave 2801, 559 and 459 on a park with trees.
constexpr int kRounds = 10;
/// Limits the influence of a single face with a very different colour.
constexpr double kMaxDistance = 2 * kOutlierDistance;

void measure_disagreement(std::span<const ViewRecord> records, const PhotoGains& gains,
                          std::vector<ColorSample>& samples, std::vector<double>& distance) {
  const auto full =
      std::count_if(records.begin(), records.end(), [](const ViewRecord& item) { return item.record->is_full(); });
  samples.clear();
  for (const ViewRecord& item : records) {
    samples.push_back(gains.sample(item));
    samples.back().votes = full < 3 || item.record->is_full();
  }
  disagreement(samples, distance);
  for (std::size_t i = 0; i < records.size(); ++i)
    records[i].record->disagreement = fixed_distance(std::min(distance[i], kMaxDistance));
}

constexpr std::uint32_t kNoRecord = 0xFFFFFFFFu;

/// `record_of_face`: work space, kNoRecord for every face before and after.
void average_over_faces(std::vector<FaceRecord>& records, const Grouped<std::uint32_t>& neighbours,
                        std::vector<std::uint32_t>& record_of_face) {
  for (std::uint32_t i = 0; i < records.size(); ++i) record_of_face[records[i].face] = i;
  std::vector<std::uint16_t> before(records.size());
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < records.size(); ++i) before[i] = records[i].disagreement;
    for (std::size_t i = 0; i < records.size(); ++i) {
      std::uint32_t sum = before[i], count = 1;
      for (const std::uint32_t face : neighbours[records[i].face])
        if (const std::uint32_t other = record_of_face[face]; other != kNoRecord) {
          sum += before[other];
          ++count;
        }
      records[i].disagreement = static_cast<std::uint16_t>((sum + count / 2) / count);
    }
  }
  for (const FaceRecord& record : records) record_of_face[record.face] = kNoRecord;
}

}  // namespace

void find_outliers(RecordsByView& by_view, std::size_t faces, const FaceGraph& graph) {
  if (by_view.empty()) return;
  PhotoGains gains(std::size_t{by_view.rbegin()->first} + 1);
  for (int round = 0; round < 2; ++round) gains.refine(by_view, faces);
  for_each_chunk(by_view, faces, 1, [&](std::size_t, const Grouped<ViewRecord>& records) {
    std::vector<ColorSample> samples;
    std::vector<double> distance;
    for (std::size_t face = 0; face < records.groups(); ++face)
      measure_disagreement(records[face], gains, samples, distance);
  });
  const Grouped<std::uint32_t> neighbours = group_neighbours(faces, graph.edges);
  std::vector<std::vector<FaceRecord>*> views;
  for (auto& [view, records] : by_view) views.push_back(&records);
  tbb::enumerable_thread_specific<std::vector<std::uint32_t>> record_of_face;
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t view) {
    std::vector<std::uint32_t>& mine = record_of_face.local();
    mine.resize(faces, kNoRecord);
    average_over_faces(*views[view], neighbours, mine);
  });
}

}  // namespace gpvc::labeling
