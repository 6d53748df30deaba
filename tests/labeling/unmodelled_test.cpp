#include "labeling/costs/unmodelled.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "labeling/costs/cells.h"
#include "labeling/costs/photo_consistency.h"

namespace gpvc::labeling {
namespace {

constexpr std::uint32_t kSide = 40;  // of a square of faces, each of 64 pixels

std::uint32_t face_at(std::uint32_t x, std::uint32_t y) { return y * kSide + x; }

Grouped<std::uint32_t> neighbours_of_square() {
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      if (x + 1 < kSide) pairs.push_back({face_at(x, y), face_at(x + 1, y)});
      if (y + 1 < kSide) pairs.push_back({face_at(x, y), face_at(x, y + 1)});
    }
  return group_neighbours(std::size_t{kSide} * kSide, pairs);
}

// 0 to 1, by three numbers.
double chance(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  std::uint32_t h = a * 0x9E3779B1U ^ b * 0x85EBCA77U ^ c * 0xC2B2AE3DU;
  h ^= h >> 15U;
  h *= 0x2C1B3C6DU;
  h ^= h >> 13U;
  return (h >> 8U) / 16777216.0;
}

// A road of grey slabs, which all photos show alike, and a canopy, of which each shows other leaves.
FaceRecord record(std::uint32_t face, std::uint32_t view, bool canopy) {
  FaceRecord result;
  result.face = face;
  result.visible = kWholeShare;
  result.pixels = 64;
  const double slab = 130 + 30 * chance(face, 7, 7) + 4 * chance(face, view, 1);
  const double leaf = 60 + 70 * chance(face, view, 2);
  const std::array<double, 3> rgb = canopy ? std::array{leaf * 0.8, leaf, leaf * 0.5} : std::array{slab, slab, slab};
  for (std::size_t c = 0; c < 3; ++c) result.color[c] = static_cast<std::uint16_t>(256 * rgb[c]);
  result.contrast = static_cast<std::uint16_t>(256 * (canopy ? 24 : 5));
  return result;
}

// Records of a square of which view v shows the canopy where is_canopy(v, x, y).
RecordsByView records_of(std::uint32_t views,
                         const std::function<bool(std::uint32_t, std::uint32_t, std::uint32_t)>& is_canopy) {
  RecordsByView by_view;
  for (std::uint32_t v = 0; v < views; ++v)
    for (std::uint32_t y = 0; y < kSide; ++y)
      for (std::uint32_t x = 0; x < kSide; ++x) by_view[v].push_back(record(face_at(x, y), v, is_canopy(v, x, y)));
  return by_view;
}

bool in_middle(std::uint32_t x, std::uint32_t y) { return x >= 14 && x < 26 && y >= 14 && y < 26; }

bool is_out(const FaceRecord& r) { return r.disagreement > fixed_distance(kOutlierMeanDistance); }

// The shares of the faces of the canopy and of the road where the views are outliers.
struct Shares {
  double canopy = 0, road = 0;
};
Shares outliers(const RecordsByView& by_view,
                const std::function<bool(std::uint32_t, std::uint32_t, std::uint32_t)>& is_canopy) {
  std::array<double, 2> out{}, all{};
  for (const auto& [view, records] : by_view)
    for (const FaceRecord& r : records) {
      const std::size_t kind = is_canopy(view, r.face % kSide, r.face / kSide) ? 0 : 1;
      all[kind] += 1;
      out[kind] += is_out(r) ? 1 : 0;
    }
  return {out[0] / std::max(all[0], 1.0), out[1] / std::max(all[1], 1.0)};
}

Shares judged(std::uint32_t views, const std::function<bool(std::uint32_t, std::uint32_t, std::uint32_t)>& is_canopy,
              std::span<const std::uint32_t> photo_of_view = {}) {
  RecordsByView by_view = records_of(views, is_canopy);
  judge_cells(by_view, make_cells(by_view, PhotoColors({}, views), neighbours_of_square()), photo_of_view);
  return outliers(by_view, is_canopy);
}

TEST(Unmodelled, TwoOfSevenPhotosShowTheRoad) {
  const auto is_canopy = [](std::uint32_t v, std::uint32_t x, std::uint32_t y) { return v >= 2 && in_middle(x, y); };
  const Shares shares = judged(7, is_canopy);
  EXPECT_GT(shares.canopy, 0.75);
  EXPECT_LT(shares.road, 0.01);
}

// The road is an outlier by the majority of colours; agreement in structure makes it an inlier.
TEST(Unmodelled, WhatAPairAgreesOnIsNoOutlier) {
  const auto is_canopy = [](std::uint32_t v, std::uint32_t x, std::uint32_t y) { return v >= 2 && in_middle(x, y); };
  RecordsByView by_view = records_of(7, is_canopy);
  for (auto& [view, records] : by_view)
    if (view < 2)
      for (FaceRecord& r : records)
        if (in_middle(r.face % kSide, r.face / kSide)) r.disagreement = fixed_distance(kMaxDistance);
  judge_cells(by_view, make_cells(by_view, PhotoColors({}, 7), neighbours_of_square()), {});
  EXPECT_LT(outliers(by_view, is_canopy).road, 0.05);
}

// All pairs of a cell's views are compared: of ten thousand photos, only those that show it largest.
TEST(Unmodelled, CellsHaveTheirLargestSights) {
  constexpr std::uint32_t kViews = kMostSights + 50;
  RecordsByView by_view = records_of(kViews, [](auto...) { return false; });
  const auto rank = [](std::uint32_t view) { return view * 37 % kViews; };  // 37 has no divisor in common with kViews
  static_assert(kViews % 37 != 0);
  for (auto& [view, records] : by_view)
    for (FaceRecord& r : records) r.pixels = static_cast<std::uint16_t>(64 + rank(view));
  const Cells cells = make_cells(by_view, PhotoColors({}, kViews), neighbours_of_square());
  ASSERT_GT(cells.count(), 100);
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    const auto sights = cells.sights[cell];
    EXPECT_EQ(sights.size(), kMostSights);
    EXPECT_TRUE(std::ranges::is_sorted(sights, {}, &CellSight::view));
    EXPECT_TRUE(std::ranges::all_of(sights, [&](const CellSight& s) { return rank(s.view) >= kViews - kMostSights; }));
  }
}

// One photo against one: the canopy begins with a step, and is like nothing around.
TEST(Unmodelled, OneOfTwoPhotosShowsTheRoad) {
  const auto is_canopy = [](std::uint32_t v, std::uint32_t x, std::uint32_t y) { return v == 1 && in_middle(x, y); };
  const Shares shares = judged(2, is_canopy);
  EXPECT_GT(shares.canopy, 0.9);
  EXPECT_LT(shares.road, 0.001);
}

TEST(Unmodelled, OneOfThreePhotosShowsTheRoad) {
  const auto is_canopy = [](std::uint32_t v, std::uint32_t x, std::uint32_t y) { return v != 1 && in_middle(x, y); };
  const Shares shares = judged(3, is_canopy);
  EXPECT_GT(shares.canopy, 0.9);
  EXPECT_LT(shares.road, 0.02);
}

TEST(Unmodelled, NothingIsRefusedWherePhotosAgree) {
  const Shares shares = judged(4, [](std::uint32_t, std::uint32_t, std::uint32_t) { return false; });
  EXPECT_EQ(shares.road, 0);
}

TEST(Unmodelled, EachFaceKeepsAViewWhereAllDiffer) {
  RecordsByView by_view = records_of(4, [](std::uint32_t, std::uint32_t, std::uint32_t) { return true; });
  judge_cells(by_view, make_cells(by_view, PhotoColors({}, 4), neighbours_of_square()), {});
  for (std::size_t face = 0; face < std::size_t{kSide} * kSide; ++face) {
    std::size_t kept = 0;
    for (const auto& [view, records] : by_view) kept += is_out(records[face]) ? 0 : 1;
    ASSERT_GT(kept, 0U) << face;
  }
}

TEST(Unmodelled, OneFaceIsNoArea) {
  const auto is_canopy = [](std::uint32_t v, std::uint32_t x, std::uint32_t y) { return v == 3 && x == 20 && y == 20; };
  EXPECT_EQ(judged(5, is_canopy).canopy, 0);
}

// The views of a panorama are one photo, and do not confirm each other.
TEST(Unmodelled, ViewsOfAPhotoAreNoWitnesses) {
  const auto is_canopy = [](std::uint32_t v, std::uint32_t x, std::uint32_t y) { return v < 2 && in_middle(x, y); };
  RecordsByView by_view = records_of(4, is_canopy);
  for (std::size_t i = 0; i < by_view[0].size(); ++i) by_view[1][i] = by_view[0][i];
  judge_cells(by_view, make_cells(by_view, PhotoColors({}, 4), neighbours_of_square()),
              std::array<std::uint32_t, 4>{0, 0, 2, 3});
  EXPECT_GT(outliers(by_view, is_canopy).canopy, 0.95);
}

TEST(Unmodelled, IsTheSameForAnyNumberOfThreads) {
  const auto is_canopy = [](std::uint32_t v, std::uint32_t x, std::uint32_t y) { return v >= 3 && in_middle(x, y); };
  std::vector<RecordsByView> results;
  for (const std::size_t threads : {1U, 4U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(records_of(6, is_canopy));
    judge_cells(results.back(), make_cells(results.back(), PhotoColors({}, 6), neighbours_of_square()), {});
  }
  for (const auto& [view, records] : results[0])
    for (std::size_t i = 0; i < records.size(); ++i)
      ASSERT_EQ(records[i].disagreement, results[1][view][i].disagreement);
}

TEST(Cells, ClustersAreConnectedAndOfTheWantedSize) {
  const Grouped<std::uint32_t> neighbours = neighbours_of_square();
  std::vector<float> sizes(neighbours.groups(), 3);
  sizes[5] = 0;
  const Clusters clusters = make_clusters(neighbours, sizes, 24);
  EXPECT_EQ(clusters.of_node[5], kNoCell);
  std::vector<float> size(clusters.count, 0);
  for (std::size_t node = 0; node < sizes.size(); ++node)
    if (clusters.of_node[node] != kNoCell) size[clusters.of_node[node]] += 3;
  for (const float s : size) {
    EXPECT_GE(s, 12);
    EXPECT_LE(s, 24 + 5 * 9);
  }
  // Of each cluster, all is reached from its lowest node.
  std::vector<std::uint8_t> reached(sizes.size(), 0), begun(clusters.count, 0);
  std::vector<std::uint32_t> queue;
  for (std::uint32_t seed = 0; seed < sizes.size(); ++seed) {
    const std::uint32_t cluster = clusters.of_node[seed];
    if (cluster == kNoCell || begun[cluster] != 0) continue;
    begun[cluster] = 1;
    queue.assign(1, seed);
    reached[seed] = 1;
    for (std::size_t i = 0; i < queue.size(); ++i)
      for (const std::uint32_t beside : neighbours[queue[i]])
        if (clusters.of_node[beside] == cluster && reached[beside] == 0) {
          reached[beside] = 1;
          queue.push_back(beside);
        }
  }
  EXPECT_EQ(std::accumulate(reached.begin(), reached.end(), std::size_t{0}), sizes.size() - 1);
}

TEST(Cells, ContrastIsThatOfAllPixels) {
  RecordsByView by_view;
  for (std::uint32_t face = 0; face < 2; ++face) {
    FaceRecord r = record(face, 0, false);
    r.pixels = 10;
    r.color = {static_cast<std::uint16_t>(256 * (face == 0 ? 90 : 110)), 0, 0};
    r.color[1] = r.color[2] = r.color[0];
    r.contrast = 256 * 10;
    by_view[0].push_back(r);
  }
  const Cells cells = make_cells(by_view, PhotoColors({}, 1), group_neighbours(2, {{0, 1}}));
  ASSERT_EQ(cells.count(), 1U);
  ASSERT_EQ(cells.sights[0].size(), 1U);
  EXPECT_FLOAT_EQ(cells.sights[0][0].rgb[0], 100);
  EXPECT_NEAR(std::exp2(cells.sights[0][0].log_contrast) - kNoContrast, std::sqrt(200.0F), 0.01F);
  EXPECT_EQ(cells.sights[0][0].shown, 3);
}

}  // namespace
}  // namespace gpvc::labeling
