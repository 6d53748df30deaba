#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "labeling/labeling.h"
#include "labeling/solver/coarsening.h"
#include "labeling/solver/expansion.h"
#include "labeling/solver/patches.h"

namespace gpvc::labeling {
namespace {

struct Instance {
  CostTable table;
  FaceGraph graph;
};

/// A grid of faces, each joined to its right and lower neighbour, with random costs. Each of `views` labels is a
/// candidate of a face with probability `density`.
Instance random_grid(std::uint32_t width, std::uint32_t height, std::uint32_t views, double density, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  Instance instance;
  instance.table.first.push_back(0);
  for (std::uint32_t face = 0; face < width * height; ++face) {
    for (std::uint32_t view = 0; view < views; ++view)
      if (unit(random) < density) {
        instance.table.views.push_back(view);
        instance.table.costs.push_back(static_cast<float>(unit(random)));
      }
    instance.table.first.push_back(instance.table.views.size());
  }
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      if (x + 1 < width) instance.graph.edges.push_back({y * width + x, y * width + x + 1});
      if (y + 1 < height) instance.graph.edges.push_back({y * width + x, (y + 1) * width + x});
    }
  return instance;
}

/// The lowest energy of all labelings.
double brute_force_minimum(const Instance& instance, double smoothness) {
  const CostTable& table = instance.table;
  std::vector<std::size_t> choice(table.first.begin(), table.first.end() - 1);
  std::vector<ViewId> labels(table.faces(), kNoView);
  double best = 1e300;
  while (true) {
    for (std::size_t face = 0; face < table.faces(); ++face)
      if (table.first[face] < table.first[face + 1]) labels[face] = ViewId{table.views[choice[face]]};
    best = std::min(best, labeling_energy(table, instance.graph, labels, smoothness));
    std::size_t face = 0;
    for (; face < table.faces(); ++face) {
      if (choice[face] + 1 < table.first[face + 1]) {
        ++choice[face];
        break;
      }
      choice[face] = table.first[face];
    }
    if (face == table.faces()) return best;
  }
}

/// Rounding of sums of some dozen terms in double, in another order.
constexpr double kSumError = 1e-12;

Selection solve(const Instance& instance, double smoothness) {
  SolverOptions options;
  options.smoothness = smoothness;
  return select_views(instance.table, instance.graph, options, {});
}

TEST(Labeling, EnergyOfGivenLabels) {
  //  0 - 1 - 2, costs of the two views (.1 .5) (.2 .2) (-)
  const CostTable table{{0, 2, 4, 4}, {3, 7, 3, 7}, {0.125f, 0.5f, 0.25f, 0.25f}};
  const FaceGraph graph{{{0, 1}, {1, 2}}};
  EXPECT_DOUBLE_EQ(labeling_energy(table, graph, std::vector{ViewId{3}, ViewId{3}, kNoView}, 2), 0.375);
  EXPECT_DOUBLE_EQ(labeling_energy(table, graph, std::vector{ViewId{7}, ViewId{3}, kNoView}, 2), 2.75);
}

// One expansion over two labels is a cut over all labelings, so from any start it ends at the optimum.
TEST(Labeling, TwoViewsReachTheOptimum) {
  for (unsigned seed = 0; seed < 60; ++seed)
    for (const double smoothness : {0.0, 0.1, 0.5, 2.0}) {
      const Instance instance = random_grid(4, 3, 2, 1.0, seed);
      EXPECT_NEAR(solve(instance, smoothness).energy, brute_force_minimum(instance, smoothness), kSumError)
          << "seed " << seed << " smoothness " << smoothness;
    }
}

TEST(Labeling, WithoutSmoothnessEveryFaceTakesItsCheapest) {
  const Instance instance = random_grid(5, 2, 3, 0.8, 3);
  EXPECT_NEAR(solve(instance, 0).energy, brute_force_minimum(instance, 0), kSumError);
}

// Boykov, Veksler, Zabih 2001, theorem 6.1: within twice the optimum for Potts.
TEST(Labeling, ManyViewsStayWithinTwiceTheOptimum) {
  double sum = 0, optimal_sum = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Instance instance = random_grid(3, 3, 4, 0.7, seed);
    const double smoothness = 0.05 * (1 + seed % 10);
    const double energy = solve(instance, smoothness).energy, optimal = brute_force_minimum(instance, smoothness);
    EXPECT_GE(energy, optimal - kSumError) << seed;
    EXPECT_LE(energy, 2 * optimal + kSumError) << seed;
    sum += energy;
    optimal_sum += optimal;
  }
  EXPECT_LE(sum, 1.01 * optimal_sum);  // measured 1.001
}

/// The instance in which fixed faces have no choice.
Instance restricted(const Instance& instance, const std::vector<ViewId>& fixed) {
  Instance result{{}, instance.graph};
  result.table.first.push_back(0);
  for (std::size_t face = 0; face < instance.table.faces(); ++face) {
    bool found = false;
    for (std::size_t i = instance.table.first[face]; i < instance.table.first[face + 1]; ++i) {
      if (fixed[face] != kNoView && index(fixed[face]) != instance.table.views[i]) continue;
      result.table.views.push_back(instance.table.views[i]);
      result.table.costs.push_back(instance.table.costs[i]);
      found = true;
    }
    if (fixed[face] != kNoView && !found) {
      result.table.views.push_back(static_cast<std::uint32_t>(fixed[face]));
      result.table.costs.push_back(0);
    }
    result.table.first.push_back(result.table.views.size());
  }
  return result;
}

// Fixed views 0 to 2 of two candidates: view 2 is no candidate of any face.
TEST(Labeling, FixedFacesKeepTheirViewsAndTheOthersReachTheOptimum) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Instance instance = random_grid(4, 3, 2, seed % 2 == 0 ? 1.0 : 0.8, seed);
    std::mt19937 random(seed);
    std::vector<ViewId> fixed(12, kNoView);
    for (ViewId& view : fixed)
      if (random() % 3 == 0) view = ViewId{static_cast<std::uint32_t>(random() % 3)};
    SolverOptions options;
    options.smoothness = 0.4;
    const Selection selection = select_views(instance.table, instance.graph, options, {}, fixed);
    for (std::size_t face = 0; face < fixed.size(); ++face)
      if (fixed[face] != kNoView) {
        EXPECT_EQ(selection.labels[face], fixed[face]) << "seed " << seed << " face " << face;
      }
    const double energy = labeling_energy(instance.table, instance.graph, selection.labels, options.smoothness);
    EXPECT_NEAR(energy, brute_force_minimum(restricted(instance, fixed), options.smoothness), kSumError)
        << "seed " << seed;
    EXPECT_NEAR(selection.energy, energy, kSumError);
  }
}

TEST(Labeling, NoneFixedIsTheOrdinarySelection) {
  const Instance instance = random_grid(20, 20, 5, 0.6, 8);
  const std::vector<ViewId> none(instance.table.faces(), kNoView);
  EXPECT_EQ(select_views(instance.table, instance.graph, {}, {}, none).labels,
            select_views(instance.table, instance.graph, {}, {}).labels);
  EXPECT_THROW(select_views(instance.table, instance.graph, {}, {}, std::vector<ViewId>(3, kNoView)),
               std::invalid_argument);
}

TEST(Labeling, FacesWithoutCandidatesHaveNoViewAndCostNothing) {
  const Instance instance = random_grid(6, 6, 4, 0.2, 5);
  const Selection selection = solve(instance, 1);
  std::size_t without = 0;
  for (std::size_t face = 0; face < instance.table.faces(); ++face) {
    const bool none = instance.table.first[face] == instance.table.first[face + 1];
    EXPECT_EQ(selection.labels[face] == kNoView, none);
    without += none;
    bool is_candidate = none;
    for (std::size_t i = instance.table.first[face]; i < instance.table.first[face + 1]; ++i)
      is_candidate |= instance.table.views[i] == index(selection.labels[face]);
    EXPECT_TRUE(is_candidate);
  }
  EXPECT_GT(without, 5u);
  EXPECT_DOUBLE_EQ(selection.energy, labeling_energy(instance.table, instance.graph, selection.labels, 1));
}

TEST(Labeling, EmptyTable) {
  EXPECT_TRUE(select_views({{0}, {}, {}}, {}, {}, {}).labels.empty());
  const Selection none = select_views({{0, 0, 0}, {}, {}}, {{{0, 1}}}, {}, {});
  EXPECT_EQ(none.labels, (std::vector{kNoView, kNoView}));
  EXPECT_EQ(none.patches, 0u);
}

/// Far more faces than one coarse level, candidates in overlapping discs as photos are.
Instance large_instance() {
  Instance instance = random_grid(150, 100, 9, 0.6, 11);
  std::mt19937 random(5);
  for (float& cost : instance.table.costs) cost = 0.9f + cost / 10;
  for (std::size_t face = 0; face < instance.table.faces(); ++face)
    for (std::size_t i = instance.table.first[face]; i < instance.table.first[face + 1]; ++i) {
      const double dx = static_cast<double>(face % 150) - 50.0 * (instance.table.views[i] % 3) - 25,
                   dy = static_cast<double>(face / 150) - 33.0 * (instance.table.views[i] / 3) - 16;
      instance.table.costs[i] -= static_cast<float>(0.3 * std::exp(-(dx * dx + dy * dy) / 800));
    }
  return instance;
}

// Random costs are harder than those of photos, where the gap is smaller.
TEST(Labeling, FastIsCloseToThoroughAndNeverBetter) {
  const Instance instance = large_instance();
  for (const double smoothness : {0.05, 0.3, 1.0}) {
    SolverOptions options;
    options.smoothness = smoothness;
    const Selection fast = select_views(instance.table, instance.graph, options, {});
    options.thorough = true;
    options.max_sweeps = 200;
    const Selection thorough = select_views(instance.table, instance.graph, options, {});
    EXPECT_LE(thorough.energy, fast.energy) << smoothness;
    EXPECT_LE(fast.energy, 1.005 * thorough.energy) << smoothness;
    EXPECT_GT(thorough.sweeps.size(), fast.sweeps.size()) << smoothness;
  }
}

TEST(Labeling, EnergyNeverRisesFromOneBatchOfExpansionsToTheNext) {
  const Instance instance = large_instance();
  std::vector<WeightedPair> pairs;
  for (const auto& [a, b] : instance.graph.edges) pairs.push_back({a, b, 0.3f});
  const LabelProblem problem = make_problem(instance.table, pairs);
  for (const std::size_t batch : {1u, 4u, 9u}) {
    std::vector<std::uint32_t> labels = cheapest_labels(problem);
    Capacity before = fixed_energy(problem, labels);
    const Capacity start = before;
    Expander expander(problem, labels, batch);
    int sweeps = 0;
    const auto check = [&] {
      const Capacity now = fixed_energy(problem, labels);
      EXPECT_LE(now, before);
      before = now;
    };
    for (; sweeps < 50 && !expander.is_fixpoint(); ++sweeps)
      if (sweeps % 3 == 0)
        expander.sweep(check);
      else
        expander.sweep_borders(check);
    EXPECT_TRUE(expander.is_fixpoint());
    EXPECT_LT(before, start - start / 20);
    // Whole graphs, cut anew, confirm the fixpoint.
    Expander again(problem, labels, 1);
    EXPECT_EQ(again.sweep(), 0u) << "batch " << batch;
  }
}

// The middle of a solved scene, solved again within the labels around it, with the candidates of the middle alone.
TEST(Labeling, PartWithinFixedLabelsIsAsGoodAsTheWhole) {
  const Instance instance = large_instance();
  const Selection whole = solve(instance, 0.3);
  const auto is_inside = [](std::size_t face) { return face % 150 >= 50 && face % 150 < 100; };
  std::vector<ViewId> fixed = whole.labels;
  CostTable part{{0}, {}, {}};
  for (std::size_t face = 0; face < fixed.size(); ++face) {
    if (is_inside(face)) {
      fixed[face] = kNoView;
      part.views.insert(part.views.end(), instance.table.views_of(face).begin(), instance.table.views_of(face).end());
      part.costs.insert(part.costs.end(), instance.table.costs_of(face).begin(), instance.table.costs_of(face).end());
    }
    part.first.push_back(part.views.size());
  }
  SolverOptions options;
  options.smoothness = 0.3;
  const Selection solved = select_views(part, instance.graph, options, {}, fixed);
  for (std::size_t face = 0; face < fixed.size(); ++face)
    if (!is_inside(face)) {
      EXPECT_EQ(solved.labels[face], whole.labels[face]) << face;
    }
  EXPECT_LE(labeling_energy(instance.table, instance.graph, solved.labels, 0.3), 1.001 * whole.energy);
}

TEST(Labeling, SweepsReportFallingEnergy) {
  const Instance instance = large_instance();
  const Selection selection = solve(instance, 0.3);
  ASSERT_GE(selection.sweeps.size(), 3u);
  for (std::size_t i = 1; i < selection.sweeps.size(); ++i)
    EXPECT_LE(selection.sweeps[i].energy, selection.sweeps[i - 1].energy + 1e-9);
}

TEST(Labeling, SameLabelsForAnyNumberOfThreads) {
  const Instance instance = large_instance();
  const Selection many = solve(instance, 0.3);
  for (const std::size_t threads : {1u, 2u, 7u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(solve(instance, 0.3).labels, many.labels) << threads << " threads";
  }
}

TEST(Labeling, PatchesAndPairsAreCounted) {
  // Single candidates give a grid of 3 x 2 these labels:
  //   0 0 1      patches: the zeros at the left, the one at the right, the ones below, the zero at the right
  //   1 1 0      pairs: below 0-1 three times, beside 0-1 twice
  Instance instance = random_grid(3, 2, 1, 1.0, 1);
  instance.table.views = {0, 0, 1, 1, 1, 0};
  const Selection selection = solve(instance, 0.5);
  EXPECT_EQ(selection.patches, 4u);
  EXPECT_EQ(selection.differing_pairs, 5u);
}

TEST(Labeling, PairsWeighWhatTheySay) {
  // 0 -3- 1 -1- 2: both labels cost node 1 the same, so it takes the label of the heavier pair.
  const CostTable table{{0, 1, 3, 4}, {0, 0, 1, 1}, {0, 0.5f, 0.5f, 0}};
  for (const bool left : {true, false}) {
    const LabelProblem problem =
        make_problem(table, std::vector<WeightedPair>{{0, 1, left ? 3.f : 1.f}, {1, 2, left ? 1.f : 3.f}});
    std::vector<std::uint32_t> labels{0, left ? 1u : 0u, 1};
    Expander expander(problem, labels, 1);
    while (!expander.is_fixpoint()) expander.sweep();
    EXPECT_EQ(labels[1], left ? 0u : 1u);
  }
}

TEST(Coarsening, ClustersAreConnectedAndKeepTheSumOfCosts) {
  const Instance instance = large_instance();
  std::vector<WeightedPair> pairs;
  for (const auto& [a, b] : instance.graph.edges) pairs.push_back({a, b, 1});
  const LabelProblem problem = make_problem(instance.table, pairs);
  const CoarseProblem coarse = coarsen(problem, 16);
  std::vector<std::size_t> size(coarse.problem.nodes(), 0);
  std::vector<std::uint32_t> cluster_labels(problem.nodes());
  for (std::size_t node = 0; node < problem.nodes(); ++node) {
    cluster_labels[node] = coarse.cluster_of_node[node];
    if (coarse.cluster_of_node[node] != kNoLabel) ++size[coarse.cluster_of_node[node]];
  }
  // Pieces of at most half a cluster that are left over join a whole one.
  EXPECT_LE(*std::max_element(size.begin(), size.end()), 16u + 2 * 8u);
  EXPECT_GE(*std::min_element(size.begin(), size.end()), 9u);
  // Clusters as labels: as many patches as clusters, if each is connected.
  std::size_t patches = 0;
  for_each_patch(problem, cluster_labels, [&](std::span<const std::uint32_t>) { ++patches; });
  EXPECT_EQ(patches, coarse.problem.nodes());
  // Every pair between clusters is in the coarse weights, both ways.
  double across = 0, weight = 0;
  for (const auto& [a, b] : instance.graph.edges)
    across += coarse.cluster_of_node[a] != kNoLabel && coarse.cluster_of_node[b] != kNoLabel &&
              coarse.cluster_of_node[a] != coarse.cluster_of_node[b];
  for (const auto& neighbour : coarse.problem.neighbours.items) weight += static_cast<double>(neighbour.weight);
  EXPECT_EQ(weight, 2 * across);
}

TEST(Patches, SmallOnesMergeWhereTheRiseIsAllowed) {
  // A row 0 0 1 0 0 whose middle may take 0 at a cost higher by 0.75, which saves two pairs of 0.25: a rise of 0.25.
  const CostTable table{{0, 1, 2, 4, 5, 6}, {0, 0, 0, 1, 0, 0}, {0, 0, 0.75f, 0, 0, 0}};
  const LabelProblem problem =
      make_problem(table, std::vector<WeightedPair>{{0, 1, 0.25f}, {1, 2, 0.25f}, {2, 3, 0.25f}, {3, 4, 0.25f}});
  const std::vector<std::uint32_t> start{0, 0, 1, 0, 0};
  for (const auto& [max_nodes, rise, merges] : {std::tuple{1u, 0.2, false}, {1u, 0.25, true}, {0u, 0.25, false}}) {
    std::vector<std::uint32_t> labels = start;
    EXPECT_EQ(merge_small_patches(problem, max_nodes, rise, labels), merges ? 1u : 0u);
    EXPECT_EQ(labels[2], merges ? 0u : 1u);
  }
}

/// The table without one view's candidates of some faces.
CostTable without(const CostTable& table, std::span<const FaceId> faces, std::span<const ViewId> views) {
  CostTable rest;
  rest.first.push_back(0);
  for (std::size_t face = 0; face < table.faces(); ++face) {
    const bool loses = std::ranges::binary_search(faces, FaceId{static_cast<std::uint32_t>(face)});
    for (std::size_t i = table.first[face]; i < table.first[face + 1]; ++i) {
      if (loses && ViewId{table.views[i]} == views[face]) continue;
      rest.views.push_back(table.views[i]);
      rest.costs.push_back(table.costs[i]);
    }
    rest.first.push_back(rest.views.size());
  }
  return rest;
}

TEST(Reselection, ChangesLabelsNearChangedFacesAlone) {
  constexpr int kWidth = 100;
  const Instance instance = random_grid(kWidth, kWidth, 6, 0.7, 5);
  const Selection before = solve(instance, 1);
  std::vector<FaceId> changed;
  const auto distance = [](int face) {  // in edges, from the changed block
    const auto beyond = [](int at) { return std::max({40 - at, at - 49, 0}); };
    return beyond(face % kWidth) + beyond(face / kWidth);
  };
  for (int face = 0; face < kWidth * kWidth; ++face)
    if (distance(face) == 0) changed.push_back(FaceId{static_cast<std::uint32_t>(face)});
  const Instance vetoed{without(instance.table, changed, before.labels), instance.graph};
  const Reselection after = reselect_views(vetoed.table, vetoed.graph, {}, {}, before.labels, changed);

  std::size_t free = 0, relabeled = 0;
  for (int face = 0; face < kWidth * kWidth; ++face) {
    const ViewId was = before.labels[static_cast<std::size_t>(face)],
                 is = after.selection.labels[static_cast<std::size_t>(face)];
    free += distance(face) <= kReselectEdges ? 1 : 0;
    if (distance(face) == 0) {
      EXPECT_TRUE(is == kNoView || is != was) << face;
      relabeled += is != kNoView;
    }
    if (distance(face) > kReselectEdges) {
      EXPECT_EQ(is, was) << face;
    }
  }
  EXPECT_EQ(after.free_faces, free);
  EXPECT_GT(relabeled, 80u);
  // Not worse than a solution of the whole by more than the solver's own spread.
  EXPECT_LT(after.selection.energy, 1.005 * solve(vetoed, 1).energy);
  EXPECT_DOUBLE_EQ(after.selection.energy, labeling_energy(vetoed.table, vetoed.graph, after.selection.labels, 1));
}

TEST(Reselection, WithoutChangesNothingMoves) {
  const Instance instance = random_grid(40, 40, 5, 0.7, 8);
  const Selection before = solve(instance, 1);
  const Reselection after = reselect_views(instance.table, instance.graph, {}, {}, before.labels, {});
  EXPECT_EQ(after.selection.labels, before.labels);
  EXPECT_EQ(after.free_faces, 0u);
  EXPECT_EQ(after.selection.patches, before.patches);
  EXPECT_EQ(after.selection.differing_pairs, before.differing_pairs);
}

TEST(Labeling, AStartIsLeftOnlyForALowerEnergy) {
  const Instance instance = random_grid(60, 60, 5, 0.7, 11);
  SolverOptions thorough;
  thorough.thorough = true;
  const Selection best = select_views(instance.table, instance.graph, thorough, {});
  const Selection again = select_views(instance.table, instance.graph, {}, {}, {}, best.labels);
  EXPECT_EQ(again.labels, best.labels);
  const std::vector<ViewId> none(instance.table.faces(), ViewId{77});  // no candidate: each begins with its cheapest
  EXPECT_LT(select_views(instance.table, instance.graph, {}, {}, {}, none).energy, 1.02 * best.energy);
  EXPECT_THROW(select_views(instance.table, instance.graph, {}, {}, {}, std::span(none).first(5)),
               std::invalid_argument);
}

}  // namespace
}  // namespace gpvc::labeling
