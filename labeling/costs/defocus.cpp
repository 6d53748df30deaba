#include "labeling/costs/defocus.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "io/order_statistics.h"

namespace gpvc::labeling {
namespace {

/// Of a pair of views in a region. Fewer cells tell little.
constexpr double kLeastCells = kDefocusRegionCells / 4;
/// Of two views that show the same surface. Blur leaves most of what differs between cells; of a tree and the road behind it
/// nothing correlates.
constexpr double kLeastCorrelation = 0.7;
/// Squared brightness steps, in grey levels, that noise adds to those of the surface at least, and the least that tell anything.
constexpr double kNoiseSteps = 1, kLeastSteps = 0.5;
/// Averages over the regions beside.
constexpr int kAverages = 2;

/// What a view lacks in a region: the logarithm of its squared steps by those of the sharpest view, <= 0.
struct Lack {
  std::uint32_t view = 0;
  float log_steps = 0;
};
using Field = std::vector<std::vector<Lack>>;  ///< by region, views ascending

const Lack* lack_of(std::span<const Lack> of_region, std::uint32_t view) {
  const auto found = std::ranges::lower_bound(of_region, view, {}, &Lack::view);
  return found == of_region.end() || found->view != view ? nullptr : &*found;
}

/// Of one view of a pair, over the cells that both see.
struct ViewSums {
  double brightness = 0, squares = 0, steps = 0, pixels = 0;
  void add(const CellSight& sight, double level) {
    brightness += level;
    squares += level * level;
    steps += static_cast<double>(sight.steps);
    pixels += static_cast<double>(sight.pixels);
  }
};

struct PairSums {
  double cells = 0, products = 0;
  ViewSums a, b;

  double covariance(double sum_of_products, double sum_a, double sum_b) const {
    return sum_of_products - sum_a * sum_b / cells;
  }
  double without_noise(const ViewSums& view) const { return std::max(view.steps / cells - kNoiseSteps, kLeastSteps); }
  double variance(const ViewSums& view) const { return covariance(view.squares, view.brightness, view.brightness); }
  bool show_the_same() const {
    if (cells < kLeastCells) return false;
    const double both = covariance(products, a.brightness, b.brightness);
    return both > 0 && both > kLeastCorrelation * std::sqrt(variance(a) * variance(b));
  }
  /// What `view` lacks against `other`. \pre they show the same
  double lack(const ViewSums& view, const ViewSums& other) const {
    const double steps = std::log(without_noise(view) / without_noise(other));
    const double of_contrast = std::log(variance(view) / variance(other));
    const double of_distance = std::log(other.pixels / view.pixels);
    return steps - std::min(0.0, of_contrast) - std::min(0.0, of_distance);
  }
};

/// Compares the views of a region. Work space of one thread.
class RegionViews {
 public:
  void compare(const Cells& cells, std::span<const std::uint32_t> of_region, std::vector<Lack>& result) {
    list_views(cells, of_region);
    const std::size_t count = views_.size();
    pairs_.assign(count * count, {});
    for (const std::uint32_t cell : of_region) add(cells.sights[cell]);
    constexpr float kNone = std::numeric_limits<float>::max();
    std::vector<float> lack(count, kNone);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = i + 1; j < count; ++j) {
        const PairSums& pair = pairs_[i * count + j];
        if (!pair.show_the_same()) continue;
        lack[i] = std::min(lack[i], static_cast<float>(pair.lack(pair.a, pair.b)));
        lack[j] = std::min(lack[j], static_cast<float>(pair.lack(pair.b, pair.a)));
      }
    for (std::size_t i = 0; i < count; ++i)
      if (lack[i] != kNone) result.push_back({views_[i], std::min(lack[i], 0.0F)});
  }

 private:
  void list_views(const Cells& cells, std::span<const std::uint32_t> of_region) {
    views_.clear();
    for (const std::uint32_t cell : of_region)
      for (const CellSight& sight : cells.sights[cell]) views_.push_back(sight.view);
    std::ranges::sort(views_);
    views_.erase(std::unique(views_.begin(), views_.end()), views_.end());
  }

  void add(std::span<const CellSight> sights) {
    places_.clear();
    levels_.clear();
    std::size_t place = 0;
    for (const CellSight& sight : sights) {
      while (views_[place] != sight.view) ++place;
      places_.push_back(place);
      levels_.push_back(static_cast<double>(sight.rgb[0] + 2 * sight.rgb[1] + sight.rgb[2]) / 4);
    }
    for (std::size_t i = 0; i < sights.size(); ++i)
      for (std::size_t j = i + 1; j < sights.size(); ++j) {
        PairSums& pair = pairs_[places_[i] * views_.size() + places_[j]];
        pair.cells += 1;
        pair.products += levels_[i] * levels_[j];
        pair.a.add(sights[i], levels_[i]);
        pair.b.add(sights[j], levels_[j]);
      }
  }

  std::vector<std::uint32_t> views_;
  std::vector<PairSums> pairs_;      ///< by both places in views_
  std::vector<std::size_t> places_;  ///< by sight of a cell
  std::vector<double> levels_;
};

/// Standard deviation of a region's lack, from the median of what regions side by side differ by.
double deviation(const Field& field, const Grouped<std::uint32_t>& beside) {
  std::vector<float> steps;
  for (std::uint32_t region = 0; region < field.size(); ++region)
    for (const Lack& lack : field[region])
      for (const std::uint32_t other : beside[region]) {
        if (other < region) continue;
        if (const Lack* const there = lack_of(field[other], lack.view))
          steps.push_back(std::abs(there->log_steps - lack.log_steps));
      }
  if (steps.empty()) return 0;
  constexpr double kOfMedian = 1.4826 / 1.4142;  // of a normal distribution, and of a difference
  return kOfMedian * static_cast<double>(upper_median(std::span(steps)));
}

Field averaged(const Field& field, const Grouped<std::uint32_t>& beside) {
  Field result = field;
  tbb::parallel_for(std::size_t{0}, field.size(), [&](std::size_t region) {
    for (Lack& lack : result[region]) {
      float sum = lack.log_steps, count = 1;
      for (const std::uint32_t other : beside[region])
        if (const Lack* const there = lack_of(field[other], lack.view)) {
          sum += there->log_steps;
          count += 1;
        }
      lack.log_steps = sum / count;
    }
  });
  return result;
}

/// What the quality is multiplied by, see defocus.h. Exactly 1 above -sure.
float factor_of(double log_steps, double sure) {
  const double counted = std::max(log_steps, 2 * (log_steps + sure));
  return counted < 0 ? static_cast<float>(std::exp2(std::exp(counted)) - 1) : 1.0F;
}

}  // namespace

void discount_blurred(RecordsByView& by_view, const Cells& cells) {
  constexpr double kLeastSure = 1, kSureDeviations = 6;
  const Clusters regions = make_clusters(cells.beside, std::vector<float>(cells.count(), 1.0F), kDefocusRegionCells);
  const auto cells_of_region = group_items<std::uint32_t>(regions.count, [&](const auto& add) {
    for (std::uint32_t cell = 0; cell < cells.count(); ++cell) add(regions.of_node[cell], cell);
  });
  const Grouped<std::uint32_t> beside = clusters_beside(regions, cells.beside);
  Field field(regions.count);
  tbb::enumerable_thread_specific<RegionViews> of_threads;
  tbb::parallel_for(std::uint32_t{0}, regions.count, [&](std::uint32_t region) {
    of_threads.local().compare(cells, cells_of_region[region], field[region]);
  });
  const double sure = std::max(kLeastSure, kSureDeviations * deviation(field, beside));
  for (int round = 0; round < kAverages; ++round) field = averaged(field, beside);
  std::vector<std::pair<std::uint32_t, std::vector<FaceRecord>*>> views;
  for (auto& [view, records] : by_view) views.emplace_back(view, &records);
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t v) {
    std::vector<float> factor(regions.count, 1.0F);
    for (std::uint32_t region = 0; region < regions.count; ++region)
      if (const Lack* const lack = lack_of(field[region], views[v].first))
        factor[region] = factor_of(static_cast<double>(lack->log_steps), sure);
    for (FaceRecord& record : *views[v].second)
      if (const std::uint32_t cell = cells.of_face[record.face]; cell != kNoCell)
        record.quality *= factor[regions.of_node[cell]];
  });
}

}  // namespace gpvc::labeling
