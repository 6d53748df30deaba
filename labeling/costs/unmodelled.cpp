#include "labeling/costs/unmodelled.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "labeling/costs/cells.h"
#include "labeling/costs/sight_distance.h"
#include "labeling/labeling.h"

namespace gpvc::labeling {
namespace {

constexpr std::uint32_t kNoSight = 0xFFFFFFFFu;

/// Distance at which two views neither agree nor differ; by one less they agree fully, by one more they differ fully.
constexpr float kUndecided = 3;
/// A step that exceeds the least one that any view shows by so much carries exp(-1) of what the cell beside tells.
constexpr float kStep = 2;

/// Bins of distances, to 16.
constexpr std::size_t kBins = 256, kBinsPerDeviation = 16;

/// Cells of an area that a view shows something else in.
constexpr std::size_t kLeastCells = 4;

// Weights of the mean field, in natural logarithms of odds.
constexpr float kPrior = 0.5F, kAround = 4, kLikeness = 2;
/// Odds grow with this power of the number of views that agree by that of views that differ.
constexpr float kVotes = 4;

/// Cells whose disputes are held together, and which one thread works on at a time.
constexpr std::uint32_t kCellsTogether = 256;

/// The sight of a view in a cell; kNoSight if it has none there.
std::uint32_t sight_of(const Grouped<CellSight>& sights, std::uint32_t cell, std::uint32_t view) {
  const auto of_cell = sights[cell];
  const auto found = std::ranges::lower_bound(of_cell, view, {}, &CellSight::view);
  if (found == of_cell.end() || found->view != view) return kNoSight;
  return static_cast<std::uint32_t>(sights.first[cell] + static_cast<std::size_t>(found - of_cell.begin()));
}

/// What photos agree on in a region of cells.
using Palette = std::vector<Look>;

/// A view in a cell beside its own.
struct Link {
  std::uint32_t sight = kNoSight;
  float strength = 0;
};

/// What the mean field works on: cells in which views differ, or none agrees with another. Where photos fit the mesh these are few of
/// all, and all pairs of views would take most of a run's memory.
struct Disputes {
  struct Place {
    std::size_t link = 0, pair = 0;
    bool is_settled = false;
  };
  std::vector<Link> links;         ///< by cell, its views and the cells beside
  std::vector<std::int8_t> pairs;  ///< by cell, all pairs of its views
};

class MeanField {
 public:
  MeanField(const Cells& cells, std::span<const std::uint32_t> photo_of_view)
      : cells_(cells),
        photo_of_view_(photo_of_view),
        places_(cells.count()),
        disputes_((cells.count() + kCellsTogether - 1) / kCellsTogether),
        likeness_(cells.sights.items.size(), 0),
        agreeing_(cells.sights.items.size(), 0),
        surface_(cells.sights.items.size(), 0.5F) {
    measure_scatter();
    for_each_cell([&](std::uint32_t cell) { compare_views(cell); });
    for (Disputes& together : disputes_) {
      together.links.shrink_to_fit();
      together.pairs.shrink_to_fit();
    }
  }

  void solve() {
    relax(8);
    compare_with_surroundings();
    relax(12);
  }

  /// What the field says of a sight. After solve().
  bool shows_surface(std::uint32_t sight) const {
    constexpr float kSure = 0.9F, kAgreeing = 0.9F;  // one other view agrees at least
    return surface_[sight] > kSure && agreeing_[sight] > kAgreeing;
  }
  /// By sight, 1 where it shows something else and another view shows the surface: in areas of several cells, as what pairs of
  /// photos differ by in one or two is noise, and would cost seams.
  std::vector<std::uint8_t> others() const {
    constexpr float kOther = 0.2F, kSurface = 0.6F;
    std::vector<std::uint8_t> found(surface_.size(), 0);
    for_each_cell([&](std::uint32_t cell) {
      const std::size_t begin = cells_.sights.first[cell], end = cells_.sights.first[cell + 1];
      float best = 0;
      for (std::size_t i = begin; i < end; ++i) best = std::max(best, surface_[i]);
      if (best > kSurface)
        for (std::size_t i = begin; i < end; ++i) found[i] = surface_[i] < kOther ? 1 : 0;
    });
    drop_small_areas(found);
    return found;
  }

 private:
  template <class Body>
  void for_each_cell(const Body& body) const {
    tbb::parallel_for(std::size_t{0}, disputes_.size(), [&](std::size_t together) {
      const std::size_t begin = together * kCellsTogether, end = std::min(begin + kCellsTogether, cells_.count());
      for (std::size_t cell = begin; cell < end; ++cell) body(static_cast<std::uint32_t>(cell));
    });
  }

  /// Clears what is connected within a view to less than kLeastCells others.
  void drop_small_areas(std::vector<std::uint8_t>& found) const {
    struct Place {
      std::uint32_t cell, sight;
    };
    std::vector<std::uint8_t> seen(found.size(), 0);
    std::vector<Place> area;
    for (std::uint32_t seed = 0; seed < cells_.count(); ++seed)
      for (std::size_t s = cells_.sights.first[seed]; s < cells_.sights.first[seed + 1]; ++s) {
        if (found[s] == 0 || seen[s] != 0) continue;
        seen[s] = 1;
        area.assign(1, {seed, static_cast<std::uint32_t>(s)});
        for (std::size_t n = 0; n < area.size(); ++n) {
          const auto [cell, sight] = area[n];
          const auto beside = cells_.beside[cell];
          const std::span<const Link> links = links_of(cell, sight - cells_.sights.first[cell]);
          for (std::size_t k = 0; k < beside.size(); ++k) {
            const std::uint32_t other = links[k].sight;
            if (other == kNoSight || found[other] == 0 || seen[other] != 0) continue;
            seen[other] = 1;
            area.push_back({beside[k], other});
          }
        }
        if (area.size() < kLeastCells)
          for (const Place& place : area) found[place.sight] = 0;
      }
  }

  /// By view of the cell and cell beside it, the view's sight there; kNoSight where it has none.
  std::vector<std::uint32_t> sights_beside(std::uint32_t cell) const {
    const auto mine = cells_.sights[cell];
    const auto beside = cells_.beside[cell];
    std::vector<std::uint32_t> found(mine.size() * beside.size(), kNoSight);
    for (std::size_t k = 0; k < beside.size(); ++k) {
      const auto theirs = cells_.sights[beside[k]];
      const std::size_t first = cells_.sights.first[beside[k]];
      for (std::size_t i = 0, j = 0; i < mine.size(); ++i) {
        while (j < theirs.size() && theirs[j].view < mine[i].view) ++j;
        if (j < theirs.size() && theirs[j].view == mine[i].view)
          found[i * beside.size() + k] = static_cast<std::uint32_t>(first + j);
      }
    }
    return found;
  }

  void add_links(std::uint32_t cell, std::vector<Link>& links) const {
    const auto mine = cells_.sights[cell];
    const std::size_t degree = cells_.beside[cell].size(), first = links.size();
    for (const std::uint32_t sight : sights_beside(cell)) links.push_back({sight, 0});
    std::vector<float> step(mine.size());
    for (std::size_t k = 0; k < degree; ++k) {
      float least = 1e9F;
      const auto link_of = [&](std::size_t i) -> Link& { return links[first + i * degree + k]; };
      for (std::size_t i = 0; i < mine.size(); ++i) {
        const std::uint32_t other = link_of(i).sight;
        if (other == kNoSight) continue;
        step[i] = std::sqrt(squared_distance(look_of(mine[i]), look_of(cells_.sights.items[other])));
        least = std::min(least, step[i]);
      }
      for (std::size_t i = 0; i < mine.size(); ++i)
        if (link_of(i).sight != kNoSight) link_of(i).strength = std::exp(-square((step[i] - least) / kStep));
    }
  }

  /// From -kUnit where two views differ to kUnit where they agree.
  static constexpr float kUnit = 127;

  bool same_photo(std::uint32_t a, std::uint32_t b) const {
    return !photo_of_view_.empty() && photo_of_view_[a] == photo_of_view_[b];
  }

  /// Calls body(i, j, distance) for all pairs i < j of the cell's views that are of different photos.
  template <class Body>
  void for_each_pair(std::uint32_t cell, const Body& body) const {
    const auto mine = cells_.sights[cell];
    // Parts that a view does not show are made up for by the cells beside.
    const bool has_all = std::ranges::all_of(mine, &CellSight::shows_all);
    const std::vector<std::uint32_t> beside = has_all ? std::vector<std::uint32_t>{} : sights_beside(cell);
    for (std::size_t i = 0; i < mine.size(); ++i)
      for (std::size_t j = i + 1; j < mine.size(); ++j) {
        if (same_photo(mine[i].view, mine[j].view)) continue;
        body(i, j,
             std::sqrt(squared_distance(look_of(mine[i]), look_of(mine[j])) +
                       square(kOfStructure * structure_unlikeness(cell, i, j, beside))));
      }
  }

  /// A photo that is off by a pixel or two, or out of focus, differs from the others all over the mesh, and that is no sign of
  /// other things. Blurred photos resemble each other more than sharp ones do, and would outvote them. So distances are measured by
  /// the lower quartile of those between the photo and the others, which are of the surface unless things hide three quarters of
  /// it. Noise alone has a quartile of one standard deviation at most. From some tens of thousands of cells.
  void measure_scatter() {
    constexpr std::size_t kCells = 1U << 15U;
    const auto stride = static_cast<std::uint32_t>(cells_.count() / kCells + 1);
    std::uint32_t views = 0;
    for (const CellSight& sight : cells_.sights.items) views = std::max(views, sight.view + 1);
    std::vector<std::atomic<std::uint32_t>> counts(views * kBins);
    for_each_cell([&](std::uint32_t cell) {
      if (cell % stride != 0) return;
      const auto mine = cells_.sights[cell];
      for_each_pair(cell, [&](std::size_t i, std::size_t j, float distance) {
        const auto bin =
            std::min(static_cast<std::size_t>(distance * static_cast<float>(kBinsPerDeviation)), kBins - 1);
        for (const std::uint32_t view : {mine[i].view, mine[j].view})
          counts[view * kBins + bin].fetch_add(1, std::memory_order_relaxed);
      });
    });
    scatter_.reserve(views);
    for (std::uint32_t view = 0; view < views; ++view)
      scatter_.push_back(std::max(1.0F, lower_quartile(std::span(counts).subspan(view * kBins, kBins))));
  }

  /// 0 of none.
  static float lower_quartile(std::span<const std::atomic<std::uint32_t>> bins) {
    double quarter = 0;
    for (const std::atomic<std::uint32_t>& bin : bins) quarter += bin / 4.0;
    if (!(quarter > 0)) return 0;
    std::size_t bin = 0;
    for (; bins[bin] < quarter; ++bin) quarter -= bins[bin];
    return static_cast<float>(static_cast<double>(bin) + quarter / bins[bin]) / static_cast<float>(kBinsPerDeviation);
  }

  /// Calls for cells that are held together come from one thread, in ascending order.
  void compare_views(std::uint32_t cell) {
    const auto mine = cells_.sights[cell];
    Disputes& together = disputes_[cell / kCellsTogether];
    Disputes::Place& place = places_[cell];
    place = {together.links.size(), together.pairs.size(), false};
    together.pairs.resize(place.pair + mine.size() * mine.size());
    std::int8_t* pairs = together.pairs.data() + place.pair;
    for_each_pair(cell, [&](std::size_t i, std::size_t j, float distance) {
      const float scatter = std::sqrt((square(scatter_[mine[i].view]) + square(scatter_[mine[j].view])) / 2);
      const float agreement = std::clamp(kUndecided - distance / scatter, -1.0F, 1.0F);
      const auto stored = static_cast<std::int8_t>(std::lround(kUnit * agreement));
      pairs[i * mine.size() + j] = stored;
      pairs[j * mine.size() + i] = stored;
    });
    place.is_settled = settle(cell);
    if (place.is_settled)
      together.pairs.resize(place.pair);
    else
      add_links(cell, together.links);
  }

  /// Where no two views differ, and some agree, all show the surface: nothing around would change that.
  bool settle(std::uint32_t cell) {
    const auto pairs = pairs_of(cell);
    if (differ(pairs) || std::ranges::all_of(pairs, [](std::int8_t pair) { return pair <= 0; })) return false;
    const std::size_t views = cells_.sights[cell].size();
    for (std::size_t i = 0; i < views; ++i) {
      surface_[cells_.sights.first[cell] + i] = 1;
      const auto of_view = pairs.subspan(i * views, views);
      agreeing_[cells_.sights.first[cell] + i] =
          static_cast<float>(std::accumulate(of_view.begin(), of_view.end(), 0)) / kUnit;
    }
    return true;
  }
  static bool differ(std::span<const std::int8_t> pairs) {
    return std::ranges::any_of(pairs, [](std::int8_t pair) { return pair < 0; });
  }
  /// Of a cell that is not settled: all pairs of its views, and the links of one.
  std::span<const std::int8_t> pairs_of(std::uint32_t cell) const {
    const std::size_t views = cells_.sights[cell].size();
    return std::span(disputes_[cell / kCellsTogether].pairs).subspan(places_[cell].pair, views * views);
  }
  std::span<const Link> links_of(std::uint32_t cell, std::size_t i) const {
    const std::size_t degree = cells_.beside[cell].size();
    return std::span(disputes_[cell / kCellsTogether].links).subspan(places_[cell].link + i * degree, degree);
  }

  /// \param beside see sights_beside(); may be empty where both views show all parts
  float structure_unlikeness(std::uint32_t cell, std::size_t i, std::size_t j,
                             std::span<const std::uint32_t> beside) const {
    const CellSight &a = cells_.sights[cell][i], &b = cells_.sights[cell][j];
    StructureSums sums;
    sums.add(a, b);
    if (!a.shows_all() || !b.shows_all()) {
      const std::size_t degree = cells_.beside[cell].size();
      for (std::size_t k = 0; k < degree; ++k) {
        const std::uint32_t x = beside[i * degree + k], y = beside[j * degree + k];
        if (x != kNoSight && y != kNoSight) sums.add(cells_.sights.items[x], cells_.sights.items[y]);
      }
    }
    return sums.unlikeness(natural_variance(a.rgb, b.rgb));
  }

  /// Mean-field steps, halfway each, of all cells at once.
  void relax(int steps) {
    std::vector<float> next = surface_;
    for (int n = 0; n < steps; ++n) {
      for_each_cell([&](std::uint32_t cell) {
        if (!places_[cell].is_settled) update(cell, std::span(next).subspan(cells_.sights.first[cell]));
      });
      surface_.swap(next);
    }
  }

  /// Sets next[i] for each view i of the cell.
  void update(std::uint32_t cell, std::span<float> next) {
    const std::size_t begin = cells_.sights.first[cell], views = cells_.sights[cell].size();
    const std::span<const std::int8_t> pairs = pairs_of(cell);
    std::array<float, kMostSights> agree, differ;
    std::fill_n(agree.begin(), views, 0.0F);
    std::fill_n(differ.begin(), views, 0.0F);
    // Of pairs (i, j) those of a j lie one after the other, too, so that the compiler vectorizes the sums.
    for (std::size_t j = 0; j < views; ++j)
      for (std::size_t i = 0; i < views; ++i) {
        const float weight = static_cast<float>(pairs[j * views + i]) * surface_[begin + j];
        agree[i] += std::max(weight, 0.0F);
        differ[i] += std::max(-weight, 0.0F);
      }
    for (std::size_t i = 0; i < views; ++i) {
      const std::span<const Link> links = links_of(cell, i);
      float around = 0;
      for (const Link& link : links)
        if (link.sight != kNoSight) around += link.strength * (2 * surface_[link.sight] - 1);
      if (!links.empty()) around /= static_cast<float>(links.size());
      agreeing_[begin + i] = agree[i] / kUnit;
      static_assert(kVotes == 4);
      const float votes = square(square((1 + differ[i] / kUnit) / (1 + agree[i] / kUnit)));
      const float found = 1 / (1 + votes * std::exp(-(kPrior + kAround * around + kLikeness * likeness_[begin + i])));
      next[i] = 0.5F * surface_[begin + i] + 0.5F * found;
    }
  }

  /// Per cell what the photos agree on; none where they do not.
  std::vector<std::optional<Look>> agreed_looks() const {
    constexpr float kSurface = 0.8F, kAgreeing = 0.7F;
    std::vector<std::optional<Look>> looks(cells_.count());
    for_each_cell([&](std::uint32_t cell) {
      Look sum;
      float views = 0;
      for (std::size_t i = cells_.sights.first[cell]; i < cells_.sights.first[cell + 1]; ++i) {
        if (surface_[i] < kSurface || agreeing_[i] < kAgreeing) continue;
        for (std::size_t c = 0; c < 3; ++c) sum.rgb[c] += cells_.sights.items[i].rgb[c];
        sum.log_contrast += cells_.sights.items[i].log_contrast;
        views += 1;
      }
      if (!(views > 0)) return;
      for (float& level : sum.rgb) level /= views;
      looks[cell] = Look{sum.rgb, sum.log_contrast / views};
    });
    return looks;
  }

  /// Finds how like each view of a cell where views differ is to what photos agree on in regions of some hundred cells around.
  void compare_with_surroundings() {
    constexpr float kRegionCells = 64;
    constexpr std::size_t kLooks = 64;  // of a region, evenly
    const Clusters regions = make_clusters(cells_.beside, std::vector<float>(cells_.count(), 1.0F), kRegionCells);
    const Grouped<std::uint32_t> regions_beside = clusters_beside(regions, cells_.beside);
    std::vector<Palette> palettes(regions.count);
    const std::vector<std::optional<Look>> looks = agreed_looks();
    for (std::uint32_t cell = 0; cell < cells_.count(); ++cell)
      if (looks[cell]) palettes[regions.of_node[cell]].push_back(*looks[cell]);
    for (Palette& palette : palettes) {
      const std::size_t stride = palette.size() / (kLooks + 1) + 1;
      std::size_t kept = 0;
      for (std::size_t i = 0; i < palette.size(); i += stride) palette[kept++] = palette[i];
      palette.resize(kept);
    }
    for_each_cell([&](std::uint32_t cell) {
      if (places_[cell].is_settled || !differ(pairs_of(cell))) return;
      const std::uint32_t region = regions.of_node[cell];
      compare_with(palettes, region, regions_beside[region], cell);
    });
  }

  void compare_with(std::span<const Palette> palettes, std::uint32_t region, std::span<const std::uint32_t> beside,
                    std::uint32_t cell) {
    constexpr float kMost = 2;
    const std::size_t begin = cells_.sights.first[cell], views = cells_.sights[cell].size();
    float mean = 0;
    for (std::size_t i = begin; i < begin + views; ++i) {
      const Look mine = look_of(cells_.sights.items[i]);
      float density = 0.5F, looks = 0.5F;
      const auto add = [&](const Palette& palette) {
        looks += static_cast<float>(palette.size());
        // A Gaussian, nearly: exp(-x) is the limit of (1 + x / n)^-n.
        for (const Look& look : palette) density += 1 / square(square(square(1 + squared_distance(mine, look) / 16)));
      };
      add(palettes[region]);
      for (const std::uint32_t other : beside) add(palettes[other]);
      likeness_[i] = std::log(density / looks);
      mean += likeness_[i] / static_cast<float>(views);
    }
    for (std::size_t i = begin; i < begin + views; ++i) likeness_[i] = std::clamp(likeness_[i] - mean, -kMost, kMost);
  }

  const Cells& cells_;
  std::span<const std::uint32_t> photo_of_view_;
  std::vector<Disputes::Place> places_;               ///< by cell
  std::vector<Disputes> disputes_;                    ///< of kCellsTogether cells each
  std::vector<float> likeness_, agreeing_, surface_;  ///< by sight
  std::vector<float> scatter_;                        ///< by view, what its distances are divided by
};

}  // namespace

double judging_bytes(double records, double pixels, double faces) {
  // Each sight, its place, three values of the field and the next ones, two flags; links to the cells beside, some five; the views that
  // it is compared with.
  constexpr double kSight = sizeof(CellSight) + sizeof(std::uint32_t) + 4 * sizeof(float) + 2,
                   kLinks = 5 * sizeof(Link);
  const double sights = std::min(records, pixels / static_cast<double>(kCellPixels));
  return sights * (kSight + kLinks + records / std::max(faces, 1.0));
}

void judge_cells(RecordsByView& by_view, const Cells& cells, std::span<const std::uint32_t> photo_of_view) {
  MeanField field(cells, photo_of_view);
  field.solve();
  const std::vector<std::uint8_t> others = field.others();
  std::vector<std::pair<std::uint32_t, std::vector<FaceRecord>*>> views;
  for (auto& [view, records] : by_view) views.emplace_back(view, &records);
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t v) {
    for (FaceRecord& record : *views[v].second) {
      const std::uint32_t cell = cells.of_face[record.face];
      if (cell == kNoCell || !record.is_full()) continue;
      const std::uint32_t sight = sight_of(cells.sights, cell, views[v].first);
      if (sight == kNoSight) continue;
      if (others[sight] != 0)
        record.disagreement = std::max(record.disagreement, fixed_distance(kMaxDistance));
      else if (field.shows_surface(sight) && record.margin == 0)
        record.disagreement = std::min(record.disagreement, fixed_distance(kOutlierMeanDistance));
    }
  });
}

}  // namespace gpvc::labeling
