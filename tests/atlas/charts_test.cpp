#include "atlas/charts/charts.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "atlas/baking/pages.h"
#include "atlas/charts/chart_raster.h"
#include "atlas/charts/chart_shape.h"
#include "atlas/charts/texel_set.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

class Charts : public testing::Test {
 protected:
  ChartSet make(int page_size, int padding = 8) {
    scene_.graph = labeling::face_graph(scene_.mesh);
    scene_.candidates.first.assign(scene_.mesh.faces.size() + 1, 0);
    for (const View& view : scene_.scene.views) io::write_image(view.photo, grey(view), io::ImageFormat::png, 90);
    io::PhotoCache photos(scene_.scene, std::size_t{1} << 28);
    const AtlasInput input{scene_.mesh, scene_.scene,      photos,         scene_.graph, scene_.labels,
                           scene_.tags, scene_.candidates, scene_.coverage};
    AtlasOptions options;
    options.page_size = page_size;
    options.padding = padding;
    const CoverageIndex coverage(scene_.coverage);
    return make_charts(input, options, group_neighbours(scene_.mesh.faces.size(), scene_.graph.edges), coverage, 1.0);
  }
  static Image grey(const View& view) {
    Image image{view.camera.width, view.camera.height, 3, {}};
    image.pixels.assign(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 128);
    return image;
  }
  /// Every face is in one chart, its corners lie in the chart's box, and the box with padding fits the page.
  void expect_sound(const ChartSet& set, int page_size, int padding = 8) {
    std::vector<int> seen(scene_.mesh.faces.size(), 0);
    for (std::size_t c = 0; c < set.charts.size(); ++c) {
      const Chart& chart = set.charts[c];
      EXPECT_LE(chart.width + 2 * padding, page_size);
      EXPECT_LE(chart.height + 2 * padding, page_size);
      EXPECT_TRUE(std::is_sorted(chart.faces.begin(), chart.faces.end()) || chart.kind == ChartKind::unseen);
      for (const auto face : chart.faces) {
        ++seen[face];
        EXPECT_EQ(set.face_chart[face], c);
        for (const auto& p : set.corners[face]) {
          EXPECT_GE(p.x, -1e-9);
          EXPECT_GE(p.y, -1e-9);
          EXPECT_LE(p.x, chart.width + 1e-9);
          EXPECT_LE(p.y, chart.height + 1e-9);
        }
      }
    }
    for (const int n : seen) EXPECT_EQ(n, 1);
  }
  AtlasScene scene_;
};

TEST_F(Charts, ConnectedFacesOfOneViewShareAChart) {
  /* views of 4 x 2 squares:  0 0 1 1
                              0 1 1 0   -> three charts: left 0, all of 1, the lone 0 */
  scene_.add_plane(4, 2, 1.0);
  for (int v = 0; v < 2; ++v) scene_.add_view(2, 1, 10, 400, 200, 400);
  const int views[2][4] = {{0, 1, 1, 0}, {0, 0, 1, 1}};
  for (std::size_t f = 0; f < 16; ++f) scene_.labels[f] = ViewId{static_cast<std::uint32_t>(views[f / 8][f / 2 % 4])};
  const ChartSet set = make(1024);
  expect_sound(set, 1024);
  EXPECT_EQ(set.charts.size(), 3u);
}

TEST_F(Charts, TexelCentresAreFramePixelCentres) {
  scene_.add_plane(3, 3, 0.7);
  scene_.add_view(1.03, 0.94, 9, 400, 400, 377);
  const ChartSet set = make(1024);
  ASSERT_EQ(set.charts.size(), 1u);
  const Chart& chart = set.charts[0];
  EXPECT_EQ(chart.scale, 1);
  EXPECT_EQ(chart.origin_x, std::floor(chart.origin_x));
  EXPECT_EQ(chart.origin_y, std::floor(chart.origin_y));
  const View& view = scene_.scene.views[0];
  for (std::size_t f = 0; f < scene_.mesh.faces.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      const PixelPoint p =
          pixel_from_camera(view.camera, camera_from_world(view.pose, scene_.mesh.positions[scene_.mesh.faces[f][i]]));
      const PixelPoint q = chart.frame_position(set.corners[f][i].x, set.corners[f][i].y);
      EXPECT_NEAR(p.x, q.x, 1e-9);
      EXPECT_NEAR(p.y, q.y, 1e-9);
    }
  }
}

TEST_F(Charts, LargerThanAPageIsSplitIntoConnectedParts) {
  scene_.add_plane(30, 20, 0.5);
  scene_.add_view(7.5, 5, 10, 1600, 1100, 1000);  // 1500 x 1000 px
  const ChartSet set = make(400);
  expect_sound(set, 400);
  EXPECT_GE(set.charts.size(), 12u);
  EXPECT_LE(set.charts.size(), 32u);
  for (const Chart& chart : set.charts) EXPECT_EQ(chart.scale, 1);
}

TEST_F(Charts, SingleFaceLargerThanAPageIsReduced) {
  scene_.add_plane(1, 1, 10.0);
  scene_.add_view(5, 5, 10, 1100, 1100, 1000);
  const ChartSet set = make(256);
  expect_sound(set, 256);
  ASSERT_EQ(set.charts.size(), 2u);
  EXPECT_NEAR(set.charts[0].scale, 239.0 / 1000, 1e-6);
}

TEST_F(Charts, PartialFacesOnTheSamePlaceDoNotShareTexels) {
  // A strip folded over itself: the second square lies under the first one, and both face up.
  /*   a--b      c and d lie below a and b: the squares joined at b-e project onto one another */
  scene_.mesh.positions = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {0, 0, 0}, {0, 1, 0}};
  scene_.mesh.faces = {{0, 1, 2}, {0, 2, 3}, {1, 2, 5}, {1, 5, 4}};
  // Faces 2 and 3 as listed face down; turned over they cover the same pixels as the first square.
  scene_.mesh.faces[2] = {2, 1, 5};
  scene_.mesh.faces[3] = {5, 1, 4};
  scene_.labels.assign(4, ViewId{0});
  scene_.tags.assign(4, labeling::FaceTag::partial);
  // From so far away that perspective bends none of them.
  scene_.add_view(0.5, 0.5, 80, 400, 400, 4000);
  const ChartSet set = make(1024);
  expect_sound(set, 1024);
  EXPECT_EQ(set.charts.size(), 2u);
  for (const Chart& chart : set.charts) {
    std::set<std::pair<int, int>> covered;
    for (const auto face : chart.faces)
      triangle_spans(set.corners[face], -1e-3, {0, 0, 1000, 1000}, [&](int y, int first, int last) {
        for (int x = first; x <= last; ++x) EXPECT_TRUE(covered.emplace(x, y).second);
      });
  }
}

TEST_F(Charts, PartialFaceBehindTheCameraGetsItsOwnFlatChart) {
  scene_.mesh.positions = {{-50, 0, 0}, {3, -1, 0}, {3, 1, 0}};
  scene_.mesh.faces = {{0, 1, 2}};
  scene_.labels = {ViewId{0}};
  scene_.tags = {labeling::FaceTag::partial};
  View& view = scene_.add_view(0, 0, 1, 400, 300, 300);
  view.pose.rotation = {0, -1, 0, 0, 0, -1, 1, 0, 0};  // looks along +x
  scene_.coverage.entries.push_back({FaceId{0}, ViewId{0}, 100, 200, 200, 100, 20000, 0.5f, 0});
  scene_.coverage.words.assign(200 * 100 / 64 + 1, ~std::uint64_t{0});
  const ChartSet set = make(512);
  expect_sound(set, 512);
  ASSERT_EQ(set.charts.size(), 1u);
  EXPECT_EQ(set.charts[0].kind, ChartKind::flat);
  // Isometric up to scale: ratios of edges are kept.
  const auto edge = [&](std::size_t i, std::size_t j) {
    return std::hypot(set.corners[0][i].x - set.corners[0][j].x, set.corners[0][i].y - set.corners[0][j].y);
  };
  EXPECT_NEAR(edge(0, 1) / edge(1, 2), std::hypot(53, 1) / 2, 1e-6);
  EXPECT_GT(edge(0, 1), 100);
}

TEST_F(Charts, UnseenFacesGetSmallBlocks) {
  scene_.add_plane(40, 40, 1.0);
  scene_.labels.assign(scene_.labels.size(), kNoView);
  const ChartSet set = make(512);
  expect_sound(set, 512);
  EXPECT_EQ(set.unseen_faces, scene_.mesh.faces.size());
  std::size_t texels = 0;
  for (const Chart& chart : set.charts) texels += static_cast<std::size_t>(chart.width * chart.height);
  EXPECT_LE(texels, 5 * scene_.mesh.faces.size());
}

TEST_F(Charts, PiecesOfAPhotoCloserThanTheirMarginsShareAChart) {
  /* squares of 10 px in view 0, no view sees the rest, 6 or 40 px wide:  0 . 0 .... 0 */
  scene_.add_plane(5, 1, 1.0);
  for (auto& p : scene_.mesh.positions) {
    constexpr double kColumns[] = {0, 1, 1.6, 2.6, 6.6, 7.6};
    p.x = kColumns[static_cast<int>(p.x)];
  }
  scene_.add_view(4, 0.5, 10, 200, 100, 100);
  for (std::size_t f = 0; f < 10; ++f)
    if (f / 2 % 2) scene_.leave_unseen(f);
  const ChartSet set = make(1024);
  expect_sound(set, 1024);
  ASSERT_EQ(set.charts.size(), 3u);
  EXPECT_EQ(set.charts[0].faces, (std::vector<std::uint32_t>{0, 1, 4, 5}));
  EXPECT_EQ(set.charts[0].width, 26);
  EXPECT_EQ(set.charts[1].faces, (std::vector<std::uint32_t>{8, 9}));
}

/// An L of 600 px fills half of its box: it is cut into charts of one piece.
TEST_F(Charts, LargeRaggedPiecesAreCut) {
  scene_.add_plane(24, 24, 0.25);
  scene_.add_view(3, 3, 10, 620, 620, 1000);
  for (std::size_t f = 0; f < scene_.labels.size(); ++f) {
    const WorldPoint p = point_at(scene_.mesh, f, 1.0 / 3, 1.0 / 3);
    if (p.x > 1.5 && p.y > 1.5) scene_.leave_unseen(f);
  }
  const ChartSet set = make(4096);
  expect_sound(set, 4096);
  std::size_t plain = 0;
  for (const Chart& chart : set.charts) {
    if (chart.kind != ChartKind::plain) continue;
    ++plain;
    EXPECT_EQ(chart.piece, 0u);
    EXPECT_EQ(chart.scale, 1);
  }
  EXPECT_GE(plain, 2u);
  EXPECT_LE(plain, 4u);
}

TEST(TexelSet, AgreesWithAPlainSetOfTexels) {
  std::mt19937 random(5);
  for (int n = 0; n < 200; ++n) {
    TexelSet a, b;
    std::set<std::pair<int, int>> plain_a, plain_b;
    for (int i = 0; i < 12; ++i) {
      const int y = static_cast<int>(random() % 3), first = static_cast<int>(random() % 40) - 20;
      const int last = first + static_cast<int>(random() % 4);
      bool meets = false;
      for (int x = first; x <= last; ++x) meets = meets || plain_a.contains({x, y});
      EXPECT_EQ(a.meets(y, first, last), meets);
      (i % 2 ? a : b).add(y, first, last);
      for (int x = first; x <= last; ++x) (i % 2 ? plain_a : plain_b).emplace(x, y);
    }
    const bool meet =
        std::any_of(plain_a.begin(), plain_a.end(), [&](const auto& texel) { return plain_b.contains(texel); });
    EXPECT_EQ(a.meets(b), meet);
    a.take(b);
    for (const auto& [x, y] : plain_b) EXPECT_TRUE(a.meets(y, x, x));
    for (const auto& [x, y] : plain_a) EXPECT_TRUE(a.meets(y, x, x));
  }
}

// Blocks hold every texel that a face touches with the margin around it, whatever the order in which faces come.
TEST(ChartShape, HoldsTheMarginOfEveryFace) {
  constexpr int kPadding = 8, kWidth = 48, kHeight = 40;
  const int edge = block_edge(kPadding), margin = block_margin(kPadding);
  std::mt19937 random(11);
  for (int n = 0; n < 200; ++n) {
    const auto within = [&](int most) { return std::uniform_real_distribution<double>(0, most)(random); };
    Chart chart;
    chart.width = kWidth;
    chart.height = kHeight;
    std::vector<TexelTriangle> corners;
    std::set<std::pair<int, int>> touched;
    for (std::uint32_t f = 0; f < 30; ++f) {
      TexelTriangle t;
      const double x = within(kWidth - 12), y = within(kHeight - 12);
      for (TexelPoint& p : t) p = {x + within(12), y + within(12)};
      corners.push_back(t);
      chart.faces.push_back(f);
      triangle_spans(t, 0.5, {0, 0, kWidth, kHeight}, [&](int row, int first, int last) {
        for (int column = first; column <= last; ++column) touched.emplace(column, row);
      });
    }
    const ChartShape shape = chart_shape(chart, corners, kPadding, 1024);
    std::set<std::pair<int, int>> blocks;
    for (const CellRun& run : shape.blocks.runs)
      for (int i = 0; i < run.length; ++i) blocks.emplace(run.first + i, run.row);
    std::size_t outside = 0;
    for (const auto& [x, y] : touched)
      for (const int right : {-margin, margin})
        for (const int down : {-margin, margin})
          outside += blocks.contains({(x + right + shape.inset_x) / edge, (y + down + shape.inset_y) / edge}) ? 0 : 1;
    EXPECT_EQ(outside, 0u) << n;
  }
}

TEST(TriangleSpans, AgreeWithASeparatingAxisTestOfEveryCell) {
  std::uint64_t state = 12345;
  const auto random = [&] {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state >> 40) / double(1 << 24) * 14 - 2;
  };
  for (int n = 0; n < 300; ++n) {
    const TexelTriangle t{TexelPoint{random(), random()}, TexelPoint{random(), random()},
                          TexelPoint{random(), random()}};
    std::set<std::pair<int, int>> got, expected;
    triangle_spans(t, 0.5, {0, 0, 10, 10}, [&](int y, int first, int last) {
      for (int x = first; x <= last; ++x) got.emplace(x, y);
    });
    // Clip the triangle to every cell (Sutherland, Hodgman). If anything is left, they meet.
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 10; ++x) {
        std::vector<TexelPoint> polygon(t.begin(), t.end());
        for (int side = 0; side < 4; ++side) {
          const auto inside = [&](const TexelPoint& p) {
            return side == 0 ? p.x - x : side == 1 ? x + 1 - p.x : side == 2 ? p.y - y : y + 1 - p.y;
          };
          std::vector<TexelPoint> rest;
          for (std::size_t i = 0; i < polygon.size(); ++i) {
            const TexelPoint &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
            const double a = inside(p), b = inside(q);
            if (a >= 0) rest.push_back(p);
            if ((a > 0) != (b > 0) && a != b)
              rest.push_back({p.x + a / (a - b) * (q.x - p.x), p.y + a / (a - b) * (q.y - p.y)});
          }
          polygon = rest;
        }
        if (!polygon.empty()) expected.emplace(x, y);
      }
    }
    EXPECT_EQ(got, expected) << n;
  }
}

}  // namespace
}  // namespace gpvc::atlas
