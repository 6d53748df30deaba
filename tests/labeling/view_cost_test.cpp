// From statistics to candidates and their costs: outliers, partial views, margins, coarse views.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

#include "io/order_statistics.h"
#include "labeling/costs/face_records.h"
#include "labeling/costs/outliers.h"
#include "labeling/costs/photo_consistency.h"
#include "labeling/costs/view_statistics.h"
#include "labeling/labeling.h"
#include "tests/labeling/view_scene.h"

namespace gpvc::labeling {
namespace {

using namespace test;

float cost_of(const CostTable& table, std::size_t face, std::uint32_t view) {
  for (std::size_t i = table.first[face]; i < table.first[face + 1]; ++i)
    if (table.views[i] == view) return table.costs[i];
  return -1;
}

bool is_candidate(const CostTable& table, std::size_t face, std::uint32_t view) {
  return cost_of(table, face, view) >= 0;
}

// --- photo-consistency

ConsensusScratch work;  // shared by the tests, as it is by faces

TEST(OrderStatistics, UpperMedianIsThatOfTheSortedValues) {
  std::mt19937 random(1);
  for (std::size_t count = 1; count <= 2 * kShortList; ++count)
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<float> values(count);
      for (float& value : values) value = static_cast<float>(random() % 8);  // with ties
      std::vector<float> sorted = values;
      std::sort(sorted.begin(), sorted.end());
      EXPECT_EQ(upper_median(std::span(values)), sorted[count / 2]);
      std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count / 2));
      EXPECT_TRUE(std::equal(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count / 2), sorted.begin()));
    }
}

TEST(PhotoConsistency, OneOfFewIsFound) {
  for (std::size_t count = 3; count <= 12; ++count) {
    std::vector<ColorSample> samples(count);
    for (std::size_t i = 0; i < count; ++i)
      samples[i].rgb = {100.0f + static_cast<float>(i % 3), 110, 120.0f - static_cast<float>(i % 2)};
    samples[count / 2].rgb = {200, 40, 30};
    std::vector<double> distance;
    disagreement(samples, work, distance);
    for (std::size_t i = 0; i < count; ++i)
      EXPECT_EQ(distance[i] > kOutlierDistance, i == count / 2) << i << " of " << count;
  }
}

TEST(PhotoConsistency, NoMajorityNoVerdict) {
  std::vector<double> distance;
  const std::vector<ColorSample> two{{{10, 10, 10}}, {{200, 200, 200}}};
  disagreement(two, work, distance);
  EXPECT_EQ(distance, (std::vector<double>{0, 0}));
  const std::vector<ColorSample> all_different{{{10, 10, 10}}, {{200, 10, 10}}, {{10, 200, 200}}};
  disagreement(all_different, work, distance);
  EXPECT_EQ(distance, (std::vector<double>{0, 0, 0}));
}

TEST(PhotoConsistency, ThoseWithoutAVoteAreJudged) {
  std::vector<ColorSample> samples{{{100, 100, 100}}, {{101, 100, 100}}, {{99, 100, 101}}, {{250, 0, 0}, false}};
  std::vector<double> distance;
  disagreement(samples, work, distance);
  EXPECT_LT(distance[0], kOutlierDistance);
  EXPECT_GT(distance[3], kOutlierDistance);
}

// --- candidates

/// A wall in 12 x 12 x 2 faces that five cameras see as a whole, and what each photo shows.
struct Wall {
  Mesh mesh;
  std::vector<View> views;
  Wall() {
    add_rectangle(mesh, -2, -2, 2, 2, 8, 12);
    for (int i = 0; i < 5; ++i) views.push_back(view_from(0.25 * (i - 2)));
  }

  Candidates collect(const std::vector<Image>& photos, const CostOptions& options, bool backwards = false) const {
    CandidateCollector collector(mesh, options);
    for (std::uint32_t i = 0; i < views.size(); ++i) {
      const std::uint32_t view = backwards ? static_cast<std::uint32_t>(views.size()) - 1 - i : i;
      collector.add_view(ViewId{view}, views[view], photos[view], look(mesh, views[view], ViewId{view}));
    }
    return collector.finish();
  }

  WorldPoint centroid(std::size_t face) const {
    WorldPoint sum;
    for (const std::uint32_t v : mesh.faces[face]) {
      sum.x += mesh.positions[v].x / 3;
      sum.y += mesh.positions[v].y / 3;
    }
    return sum;
  }
};

/// Photos of a wall of vertical stripes; in photo 1 a red object covers columns 20 to 39 of rows 14 to 33.
std::vector<Image> photos_with_a_visitor(const Wall& wall, const std::vector<double>& gains) {
  std::vector<Image> photos;
  for (std::size_t i = 0; i < wall.views.size(); ++i)
    photos.push_back(paint([&](int x, int y) {
      if (i == 1 && x >= 20 && x < 40 && y >= 14 && y < 34) return Color{200, 20, 20};
      const double world_x = (x + 0.5 - 32) / 8 + wall.views[i].pose.centre.x;
      const int level = static_cast<int>(gains[i] * (110 + 20 * std::sin(3 * world_x)));
      return Color{level, level, level};
    }));
  return photos;
}

/// Columns and rows of face centroids in photo 1, inward from the visitor's outline.
double depth_in_visitor(const Wall& wall, std::size_t face) {
  const WorldPoint p = wall.centroid(face);
  const double x = (p.x - wall.views[1].pose.centre.x) * 8 + 32, y = p.y * 8 + 24;
  return std::min(std::min(x - 20, 40 - x), std::min(y - 14, 34 - y));
}

TEST(Candidates, VisitorInOnePhotoIsRejectedAndNothingElse) {
  const Wall wall;
  for (const std::vector<double>& gains : {std::vector<double>{1, 1, 1, 1, 1}, {0.7, 1.0, 1.2, 1.4, 0.9}}) {
    const Candidates candidates = wall.collect(photos_with_a_visitor(wall, gains), {});
    std::size_t inside = 0;
    for (std::size_t face = 0; face < wall.mesh.faces.size(); ++face) {
      const double depth = depth_in_visitor(wall, face);
      if (depth > 2) {
        EXPECT_FALSE(is_candidate(candidates.table, face, 1)) << face;
        ++inside;
      }
      // Averaging blurs the outline by a few faces of 2.7 px.
      if (depth < -12) {
        EXPECT_TRUE(is_candidate(candidates.table, face, 1)) << face;
      }
      for (const std::uint32_t view : {0u, 2u, 3u, 4u})
        EXPECT_TRUE(is_candidate(candidates.table, face, view)) << face << " in " << view;
      EXPECT_EQ(candidates.tags[face], FaceTag::seen);
    }
    EXPECT_GT(inside, 60u);
    EXPECT_GE(candidates.rejected, inside);
  }
}

TEST(Candidates, NoneKeepsAndDampWeakens) {
  const Wall wall;
  const auto photos = photos_with_a_visitor(wall, {1, 1, 1, 1, 1});
  CostOptions options;
  options.term = DataTerm::area;
  options.outliers = Outliers::none;
  const Candidates all = wall.collect(photos, options);
  EXPECT_EQ(all.full, 5 * wall.mesh.faces.size());
  EXPECT_EQ(all.rejected, 0u);
  options.outliers = Outliers::damp;
  const Candidates damped = wall.collect(photos, options);
  EXPECT_EQ(damped.full, all.full);
  for (std::size_t face = 0; face < wall.mesh.faces.size(); ++face)
    if (depth_in_visitor(wall, face) > 2) {
      EXPECT_GT(cost_of(damped.table, face, 1), cost_of(all.table, face, 1) + 0.1f);
    }
}

TEST(Candidates, FacesThatEveryPhotoDisputesKeepTheirViews) {
  const Wall wall;
  std::vector<Image> photos;
  for (int i = 0; i < 5; ++i)
    photos.push_back(paint([=](int x, int y) {
      // Noise of eight pixels that differs from photo to photo.
      const int cell = static_cast<int>(static_cast<unsigned>(x / 8 * 31 + y / 8 * 17 + i * 101) * 2654435761u % 200);
      return Color{20 + cell, 220 - cell, (cell * 7) % 200};
    }));
  const Candidates candidates = wall.collect(photos, {});
  for (std::size_t face = 0; face < wall.mesh.faces.size(); ++face)
    EXPECT_LT(candidates.table.first[face], candidates.table.first[face + 1]);
}

TEST(Candidates, OrderOfViewsAndThreadsDoNotMatter) {
  const Wall wall;
  const auto photos = photos_with_a_visitor(wall, {1, 0.9, 1.1, 1, 1.2});
  const Candidates forwards = wall.collect(photos, {});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Candidates backwards = wall.collect(photos, {}, true);
  EXPECT_EQ(forwards.table.first, backwards.table.first);
  EXPECT_EQ(forwards.table.views, backwards.table.views);
  EXPECT_EQ(forwards.table.costs, backwards.table.costs);
  EXPECT_TRUE(std::is_sorted(forwards.table.views.begin(), forwards.table.views.begin() + 5));
}

TEST(Candidates, WantedFacesCostWhatTheyCostInTheWhole) {
  const Wall wall;
  const auto photos = photos_with_a_visitor(wall, {1, 0.9, 1.1, 1, 1.2});
  CostOptions options;
  options.term = DataTerm::gmi;
  options.outliers = Outliers::none;
  const Candidates whole = wall.collect(photos, options);
  std::vector<std::uint8_t> wanted(wall.mesh.faces.size());
  for (std::size_t face = 0; face < wanted.size(); ++face) wanted[face] = wall.centroid(face).x < 0.3;
  CandidateCollector collector(wall.mesh, options, wanted);
  for (std::uint32_t i = 0; i < wall.views.size(); ++i)
    collector.add_view(ViewId{i}, wall.views[i], photos[i], look(wall.mesh, wall.views[i], ViewId{i}));
  const Candidates part = collector.finish();
  const auto rows = [](const CostTable& table, std::size_t face) {
    const auto views = table.views_of(face);
    const auto costs = table.costs_of(face);
    return std::pair(std::vector(views.begin(), views.end()), std::vector(costs.begin(), costs.end()));
  };
  for (std::size_t face = 0; face < wanted.size(); ++face) {
    EXPECT_EQ(part.tags[face], wanted[face] != 0 ? whole.tags[face] : FaceTag::unseen);
    if (wanted[face] != 0) {
      EXPECT_EQ(rows(part.table, face), rows(whole.table, face)) << face;
    } else {
      EXPECT_TRUE(part.table.views_of(face).empty()) << face;
    }
  }
  EXPECT_THROW(CandidateCollector(wall.mesh, options, {1, 0}), std::invalid_argument);
}

// A wall of two triangles behind a board, from two cameras: each sees the wall partially, and differently.
TEST(Candidates, PartialViewsOnlyWhereNoneIsFullAndByHiddenShare) {
  Mesh mesh;
  add_rectangle(mesh, -2, -2, 2, 2, 8, 1);
  add_rectangle(mesh, -1, -1, 0.5, 0.5, 4, 1);
  CostOptions options;
  options.term = DataTerm::area;
  options.margin_px = 0;
  CandidateCollector collector(mesh, options);
  std::vector<visibility::ViewVisibility> seen;
  for (std::uint32_t i = 0; i < 2; ++i) {
    const View view = view_from(i == 0 ? 0 : -1.5);
    seen.push_back(look(mesh, view, ViewId{i}));
    collector.add_view(ViewId{i}, view, grey(100), seen.back());
  }
  const Candidates candidates = collector.finish();
  for (std::size_t face = 0; face < 4; ++face) {
    bool any_full = false;
    for (const visibility::ViewVisibility& view : seen) any_full |= view.classes[face] == visibility::FaceClass::full;
    EXPECT_EQ(candidates.tags[face], any_full ? FaceTag::seen : FaceTag::partial);
    for (std::uint32_t view = 0; view < 2; ++view)
      EXPECT_EQ(is_candidate(candidates.table, face, view),
                seen[view].classes[face] == (any_full ? visibility::FaceClass::full : visibility::FaceClass::partial));
  }
  ASSERT_EQ(candidates.tags[0], FaceTag::partial);
  const auto share = [&](std::uint32_t view) {
    for (const visibility::FaceCoverage& entry : seen[view].coverage.entries)
      if (index(entry.face) == 0) return static_cast<double>(entry.visible_share);
    return 1.0;
  };
  ASSERT_NE(share(0), share(1));
  // The hidden share counts at hidden_cost, and again in the quality, which is that of the visible part.
  const double difference =
      static_cast<double>(cost_of(candidates.table, 0, 0)) - static_cast<double>(cost_of(candidates.table, 0, 1));
  EXPECT_GE(std::abs(difference), options.hidden_cost * std::abs(share(0) - share(1)) - 1e-4);
  EXPECT_EQ(difference > 0, share(0) < share(1));
}

TEST(Candidates, MarginCostsItsShare) {
  Mesh mesh;
  add_rectangle(mesh, -4, -4, 4, 4, 8, 16);
  add_rectangle(mesh, -0.5, -0.5, 0.5, 0.5, 4, 1);
  const View view = view_from(0);
  const visibility::ViewVisibility visibility = look(mesh, view);
  std::array<Candidates, 2> result;
  CostOptions options;
  options.margin_px = 4;
  for (const std::size_t with : {0u, 1u}) {
    options.margin_cost = with == 1 ? 2.0 : 0.0;
    CandidateCollector collector(mesh, options);
    collector.add_view(ViewId{0}, view, grey(100), visibility);
    result[with] = collector.finish();
  }
  const auto margin = margin_of(mesh, view, 4);
  std::size_t costly = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    if (result[0].table.first[face] == result[0].table.first[face + 1]) continue;
    double inside = 0, pixels = 0;
    for (std::size_t i = 0; i < margin.size(); ++i)
      if (visibility.ivm.faces[i] == FaceId{static_cast<std::uint32_t>(face)}) {
        ++pixels;
        inside += margin[i];
      }
    const double rise =
        static_cast<double>(cost_of(result[1].table, face, 0)) - static_cast<double>(cost_of(result[0].table, face, 0));
    EXPECT_NEAR(rise, 2 * inside / pixels, 1e-4) << face;
    costly += rise > 0;
  }
  EXPECT_GT(costly, 8u);
}

// The same square in views of ever shorter focal length: areas 1, 1/4, 1/8 and 1/64, that is 0, 2, 3 and 6 halvings of
// which two are free and two count at most.
TEST(Candidates, CoarseViewsCostByTheirHalvings) {
  Mesh mesh;
  add_rectangle(mesh, -2, -2, 2, 2, 8, 1);
  const std::array<double, 4> area{1, 1.0 / 4, 1.0 / 8, 1.0 / 64}, counted{0, 0, 1, 2};
  std::array<Candidates, 2> result;
  CostOptions options;
  options.margin_px = 0;
  options.outliers = Outliers::none;
  for (const std::size_t with : {0u, 1u}) {
    options.coarse_cost = with == 1 ? 0.5 : 0.0;
    CandidateCollector collector(mesh, options);
    for (std::uint32_t i = 0; i < 4; ++i) {
      View view = view_from(0);
      view.camera.fx *= std::sqrt(area[i]);
      view.camera.fy *= std::sqrt(area[i]);
      collector.add_view(ViewId{i}, view, grey(100), look(mesh, view, ViewId{i}));
    }
    result[with] = collector.finish();
  }
  for (const std::size_t face : {0u, 1u})
    for (std::uint32_t i = 0; i < 4; ++i)
      EXPECT_NEAR(cost_of(result[1].table, face, i) - cost_of(result[0].table, face, i), 0.5 * counted[i], 1e-4)
          << face << " " << i;
}

/// A thin pole before the wall, which the photos show two pixels further to the right than the mesh has it: next to it
/// faces look clear of the pole and have its colour.
struct MisplacedPole {
  Wall wall;
  std::size_t wall_faces = wall.mesh.faces.size();
  std::vector<Image> photos;
  std::vector<visibility::ViewVisibility> seen;

  int red_rows;  ///< of the photos, around their middle: the rest of the pole is as grey as the wall

  explicit MisplacedPole(int rows = kHeight) : red_rows(rows) {
    add_rectangle(wall.mesh, -0.1, -3, 0.1, 3, 4, 1);
    // From one camera to the next the pole moves by 6 px on the wall, so every place is clear of it in some views.
    for (int i = 0; i < 5; ++i) wall.views[static_cast<std::size_t>(i)] = view_from(0.75 * (i - 2));
    for (std::size_t i = 0; i < wall.views.size(); ++i) {
      photos.push_back(paint([&](int x, int y) { return is_red(i, x, y) ? Color{200, 0, 0} : Color{90, 90, 90}; }));
      seen.push_back(look(wall.mesh, wall.views[i]));
    }
  }

  bool is_red(std::size_t view, int x, int y) const {
    const double left = (-0.1 - wall.views[view].pose.centre.x) * 16 + 32;
    return x + 0.5 > left + 2 && x + 0.5 < left + 2 + 3.2 && std::abs(2 * y + 1 - kHeight) < red_rows;
  }

  Candidates collect(const CostOptions& options) const {
    CandidateCollector collector(wall.mesh, options);
    for (std::uint32_t i = 0; i < wall.views.size(); ++i)
      collector.add_view(ViewId{i}, wall.views[i], photos[i], seen[i]);
    return collector.finish();
  }

  /// Calls visit(view, face of the wall) for every pixel of the wall that is red.
  template <class Visit>
  void for_each_red_pixel(Visit visit) const {
    for (std::uint32_t i = 0; i < wall.views.size(); ++i)
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const FaceId face = seen[i].ivm.at(x, y);
          if (face != kNoFace && index(face) < wall_faces && is_red(i, x, y)) visit(i, std::size_t{index(face)});
        }
  }
};

TEST(Candidates, MarginKeepsAMisplacedPoleOffTheWall) {
  const MisplacedPole pole;
  const auto red_pixels = [&](int margin_px) {
    CostOptions options;
    options.term = DataTerm::area;  // all views are equally good
    options.outliers = Outliers::none;
    options.margin_px = margin_px;
    const Selection selection = select_views(pole.collect(options).table, face_graph(pole.wall.mesh), {}, {});
    std::size_t red = 0;
    pole.for_each_red_pixel(
        [&](std::uint32_t view, std::size_t face) { red += index(selection.labels[face]) == view; });
    return red;
  };
  const std::size_t without = red_pixels(0);
  EXPECT_GT(without, 25u);
  EXPECT_LE(10 * red_pixels(CostOptions{}.margin_px), without);
}

// Red rims of a few faces: averaged with the faces around them they are no outliers, in the strip they are.
TEST(Candidates, RimsInTheStripAreOutliersByThemselves) {
  const MisplacedPole pole(6);
  const auto red_pixels = [&](int margin_px) {
    CostOptions options;
    options.margin_px = margin_px;
    const Candidates candidates = pole.collect(options);
    std::size_t red = 0;
    pole.for_each_red_pixel(
        [&](std::uint32_t view, std::size_t face) { red += is_candidate(candidates.table, face, view) ? 1 : 0; });
    return red;
  };
  const std::size_t without = red_pixels(0);
  EXPECT_GT(without, 15u);
  EXPECT_LE(5 * red_pixels(CostOptions{}.margin_px), without);
}

// Most photos have nothing but white in the middle; what it looks like is in the darker ones. Where all are white, or where the darker
// thing is not what is white in the others, white it is.
TEST(Candidates, WhatIsBurntOutComesFromDarkerPhotos) {
  const Wall wall;
  const auto shares_of_views = [&](std::array<double, 5> gains, bool tree) {
    std::vector<Image> photos;
    for (std::size_t i = 0; i < wall.views.size(); ++i)
      photos.push_back(paint([&](int x, int y) {
        const double world_x = (x + 0.5 - 32) / 8 + wall.views[i].pose.centre.x;
        const bool bright = std::abs(world_x) < 0.7;
        if (bright && tree && i == 0) return Color{30, 60, 20};
        const auto level = static_cast<int>(std::min(255.0, gains[i] * ((bright ? 180 : 60) + x % 3 + y % 5)));
        return Color{level, level, level};
      }));
    const Candidates candidates = wall.collect(photos, {});
    const Selection selection = select_views(candidates.table, face_graph(wall.mesh), {}, {});
    std::array<double, 5> share{};
    double faces = 0;
    for (std::size_t face = 0; face < wall.mesh.faces.size(); ++face) {
      if (std::abs(wall.centroid(face).x) > 0.5) continue;
      share[index(selection.labels[face])] += 1;
      faces += 1;
    }
    for (double& each : share) each /= faces;
    return share;
  };
  const auto darker = shares_of_views({1, 1.6, 1.1, 1.7, 1.6}, false);
  EXPECT_DOUBLE_EQ(darker[0] + darker[2], 1);
  const auto tree = shares_of_views({1.6, 1.6, 1.6, 1.7, 1.6}, true);
  EXPECT_DOUBLE_EQ(tree[0], 0);
}

// Where photos show what lies behind a face, or a mixture with it, there is no surface, and the photo that shows something there
// shows what stands in front. A mixture does not tell which it is: the face is filled, not left out.
TEST(Candidates, BackgroundAndMixturesHaveAVote) {
  using enum visibility::FaceClass;
  const Wall wall;
  const std::vector<Image> photos = photos_with_a_visitor(wall, {1, 1, 1, 1, 1});
  struct Case {
    visibility::FaceClass in[3];
    FaceTag tag;
  };
  const Case cases[] = {
      {{full, full, full}, FaceTag::seen},
      {{full, mixed, full}, FaceTag::seen},
      {{full, mixed, mixed}, FaceTag::unseen},
      {{full, background, background}, FaceTag::background},
      {{full, mixed, background}, FaceTag::background},
      {{mixed, mixed, background}, FaceTag::unseen},
      {{hidden, mixed, hidden}, FaceTag::unseen},
      {{full, background, hidden}, FaceTag::seen},
  };
  CandidateCollector collector(wall.mesh, {});
  std::size_t face = 0;
  for (std::uint32_t i = 0; i < 3; ++i) {
    visibility::ViewVisibility seen = look(wall.mesh, wall.views[i], ViewId{i});
    face = 0;
    for (const Case& each : cases) {
      ASSERT_EQ(seen.classes[face], full);
      seen.classes[face] = each.in[i];
      face += 17;
    }
    collector.add_view(ViewId{i}, wall.views[i], photos[i], seen);
  }
  CandidateCollector again(wall.mesh, {});
  for (std::uint32_t i = 0; i < 3; ++i)
    ASSERT_TRUE(again.add_statistics(ViewId{i}, collector.statistics_of(ViewId{i})));
  for (CandidateCollector* each : {&collector, &again}) {
    const Candidates candidates = each->finish();
    face = 0;
    for (const Case& expected : cases) {
      EXPECT_EQ(candidates.tags[face], expected.tag) << face / 17;
      face += 17;
    }
  }
}

// Someone in a panorama is in both of its views that overlap there. Against two photos without, two views are no majority,
// and one photo is an outlier.
TEST(Candidates, ViewsOfOnePhotoVoteOnce) {
  const Wall wall;
  const View view = view_from(0);
  const visibility::ViewVisibility seen = look(wall.mesh, view);
  const Image red = paint([](int x, int) { return x < 26 ? Color{200, 0, 0} : Color{90, 90, 90}; });
  const Grouped<std::uint32_t> neighbours = group_neighbours(wall.mesh.faces.size(), face_graph(wall.mesh).edges);
  const auto outliers = [&](const std::vector<std::uint32_t>& photo_of_view) {
    RecordsByView by_view;
    ViewScratch of_views;
    for (std::uint32_t v = 0; v < 4; ++v)
      by_view[v] = view_statistics(wall.mesh, view, v < 2 ? grey(90) : red, seen, {}, of_views);
    find_outliers(by_view, std::array<double, 12>{}, neighbours, photo_of_view);
    std::array<std::size_t, 4> counts{};
    for (const auto& [v, records] : by_view)
      for (const FaceRecord& record : records)
        if (wall.centroid(record.face).x < -1.25)  // pixel 22
          counts[v] += record.disagreement > fixed_distance(kOutlierMeanDistance) ? 1 : 0;
    return counts;
  };
  EXPECT_EQ(outliers({}), (std::array<std::size_t, 4>{}));
  const std::size_t all = outliers({0, 1, 2, 2})[2];
  EXPECT_GT(all, 20u);
  EXPECT_EQ(outliers({0, 1, 2, 2}), (std::array{std::size_t{0}, std::size_t{0}, all, all}));
}

// Slabs of brick, in one photo out of focus. Nothing tells from their sizes which is best.
TEST(Candidates, BlurredPhotoCostsMore) {
  Mesh mesh;
  add_rectangle(mesh, -3.5, -2.5, 3.5, 2.5, 8, 16);
  const View view = view_from(0);
  const visibility::ViewVisibility seen = look(mesh, view);
  const auto slab = [](int x, int y) { return 80 + 20 * ((x / 8 * 5 + y / 8 * 3) % 5); };
  const Image sharp = paint([&](int x, int y) {
    const int level = slab(x, y) + (x % 2 == 0 ? 10 : -10);
    return Color{level, level, level};
  });
  const Image blurred = paint([&](int x, int y) { return Color{slab(x, y), slab(x, y), slab(x, y)}; });
  const auto candidates = [&](Outliers outliers) {
    CostOptions options;
    options.outliers = outliers;
    options.margin_px = 0;
    CandidateCollector collector(mesh, options);
    for (std::uint32_t v = 0; v < 3; ++v) collector.add_view(ViewId{v}, view, v == 1 ? blurred : sharp, seen);
    return collector.finish();
  };
  const Candidates compared = candidates(Outliers::clamp), alone = candidates(Outliers::none);
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    ASSERT_EQ(compared.table.views_of(face).size(), 3U);
    const auto costs = compared.table.costs_of(face);
    EXPECT_EQ(costs[0], 0.0F);
    EXPECT_GT(costs[1], 0.5F);
    EXPECT_EQ(costs[2], 0.0F);
    EXPECT_EQ(alone.table.costs_of(face)[1], 0.0F);
  }
  EXPECT_EQ(alone.outlier_share, std::vector<double>(3, 0.0)) << "brightness steps are no disagreement";
}

TEST(Candidates, FaceThatNoViewSeesIsUnseen) {
  Mesh mesh;
  add_rectangle(mesh, -1, -1, 1, 1, -8, 1);
  CandidateCollector collector(mesh, {});
  collector.add_view(ViewId{3}, view_from(0), grey(9), look(mesh, view_from(100)));
  const Candidates candidates = collector.finish();
  EXPECT_EQ(candidates.tags, (std::vector{FaceTag::unseen, FaceTag::unseen}));
  EXPECT_EQ(candidates.table.first, (std::vector<std::size_t>{0, 0, 0}));
}

}  // namespace
}  // namespace gpvc::labeling
