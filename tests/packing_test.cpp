#include "atlas/packing.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

#include "atlas/pages.h"

namespace gpvc {
namespace {

/// Texels of a placed shape's box whose cell is set, mapped to the page; marks them and checks they were
/// free.
std::size_t paint(const PackShape& shape, const Placement& at, const Packing& packing,
                  std::vector<std::vector<std::uint8_t>>& pages) {
  const PageSize& size = packing.pages[at.page];
  std::size_t texels = 0;
  for (const CellRun& run : shape.runs) {
    for (int y = run.row * kCell; y < std::min((run.row + 1) * kCell, shape.height); ++y) {
      for (int x = run.first * kCell; x < std::min((run.first + run.length) * kCell, shape.width); ++x) {
        const ChartPlace place{
            at.page, at.x, at.y, at.turns, whole_cells(shape.width), whole_cells(shape.height), 0};
        const auto [px, py] = place.texel(x, y);
        EXPECT_TRUE(px >= 0 && py >= 0 && px < size.width && py < size.height);
        if (!(px >= 0 && py >= 0 && px < size.width && py < size.height)) return texels;
        auto& texel = pages[at.page][static_cast<std::size_t>(py) * static_cast<std::size_t>(size.width) +
                                     static_cast<std::size_t>(px)];
        EXPECT_EQ(texel, 0) << "overlap at " << px << " " << py;
        texel = 1;
        ++texels;
      }
    }
  }
  return texels;
}

/// Share of the pages' texels that shapes cover; fails on any overlap.
double check(const std::vector<PackShape>& shapes, const Packing& packing, int page_size) {
  EXPECT_EQ(packing.placements.size(), shapes.size());
  std::vector<std::vector<std::uint8_t>> pages;
  std::size_t total = 0, covered = 0;
  for (const auto& p : packing.pages) {
    EXPECT_LE(p.width, page_size);
    EXPECT_LE(p.height, page_size);
    pages.emplace_back(static_cast<std::size_t>(p.width) * static_cast<std::size_t>(p.height), 0);
    total += pages.back().size();
  }
  for (std::size_t i = 0; i < shapes.size() && !testing::Test::HasFailure(); ++i)
    covered += paint(shapes[i], packing.placements[i], packing, pages);
  return static_cast<double>(covered) / static_cast<double>(total);
}

PackShape disc(int radius) {
  PackShape shape{2 * radius, 2 * radius, {}};
  for (int row = 0; row < (2 * radius + kCell - 1) / kCell; ++row) {
    const double y = std::min(std::abs(row * kCell - radius), std::abs((row + 1) * kCell - radius));
    const double half = std::sqrt(std::max(0.0, radius * double(radius) - y * y));
    const int first = static_cast<int>((radius - half) / kCell),
              last = static_cast<int>((radius + half - 1e-9) / kCell);
    shape.runs.push_back({row, first, last - first + 1});
  }
  return shape;
}

/// An L: what a box wastes, a small square fills.
PackShape corner(int edge) {
  PackShape shape{edge, edge, {}};
  for (int row = 0; row < edge / kCell; ++row)
    shape.runs.push_back({row, 0, row < edge / kCell / 2 ? edge / kCell / 2 : edge / kCell});
  return shape;
}

TEST(Packing, NothingGivesNoPage) { EXPECT_TRUE(pack_shapes({}, 1024).pages.empty()); }

TEST(Packing, OneShapeGivesAPageOfItsSize) {
  const std::vector<PackShape> shapes{box_shape(37, 101)};
  const Packing packing = pack_shapes(shapes, 1024);
  ASSERT_EQ(packing.pages.size(), 1u);
  check(shapes, packing, 1024);
  EXPECT_EQ(packing.pages[0].width * packing.pages[0].height, 37 * 101);
}

/* 400 x 100 texels, twice: upright the page of 500 has room for four rows; the tall one must turn. */
TEST(Packing, TurnsWhatDoesNotFitUpright) {
  const std::vector<PackShape> shapes{box_shape(400, 396), box_shape(100, 400), box_shape(400, 100)};
  const Packing packing = pack_shapes(shapes, 500);
  EXPECT_EQ(packing.pages.size(), 1u);
  EXPECT_GT(check(shapes, packing, 500), 0.85);
}

TEST(Packing, SquaresFillTheCornersOfShapes) {
  /*  a . b .
      aa. bb.   four L of 64 and four squares of 32: exactly 256 x 64, if the squares go into the corners */
  std::vector<PackShape> shapes(4, corner(64));
  shapes.insert(shapes.end(), 4, box_shape(32, 32));
  const Packing packing = pack_shapes(shapes, 128);
  EXPECT_EQ(packing.pages.size(), 1u);
  EXPECT_DOUBLE_EQ(check(shapes, packing, 128), 1.0);
}

TEST(Packing, BoxesOfAnySizeNeverOverlap) {
  std::mt19937 random(7);
  std::vector<PackShape> shapes;
  for (int i = 0; i < 20000; ++i) {
    const double size = std::exp(std::uniform_real_distribution<>(std::log(12.0), std::log(160.0))(random));
    const double aspect = std::exp(std::uniform_real_distribution<>(-0.9, 0.9)(random));
    shapes.push_back(box_shape(static_cast<int>(size * aspect) + 1, static_cast<int>(size / aspect) + 1));
  }
  const Packing packing = pack_shapes(shapes, 4096);
  EXPECT_GT(packing.pages.size(), 2u);
  EXPECT_GT(check(shapes, packing, 4096), 0.85);
}

TEST(Packing, ShapesOfAnyOutlineNeverOverlap) {
  std::mt19937 random(11);
  std::vector<PackShape> shapes;
  for (int i = 0; i < 3000; ++i) {
    const int size = 4 + static_cast<int>(std::exp(std::uniform_real_distribution<>(1.0, 5.0)(random)));
    shapes.push_back(i % 3 == 0   ? disc(size)
                     : i % 3 == 1 ? corner(8 * (size / 4))
                                  : box_shape(size, 2 * size));
  }
  const Packing packing = pack_shapes(shapes, 1024);
  EXPECT_GT(check(shapes, packing, 1024), 0.8);
}

TEST(Packing, OversizePageCountIsNearTheArea) {
  const std::vector<PackShape> shapes(9, box_shape(500, 500));
  const Packing packing = pack_shapes(shapes, 1000);
  EXPECT_EQ(packing.pages.size(), 3u);
  check(shapes, packing, 1000);
  EXPECT_EQ(packing.pages.back().width, 500);
  EXPECT_EQ(packing.pages.back().height, 500);
}

TEST(Packing, SmallScenesGiveSmallNearSquarePages) {
  const std::vector<PackShape> shapes(100, box_shape(40, 40));
  const Packing packing = pack_shapes(shapes, 8192);
  ASSERT_EQ(packing.pages.size(), 1u);
  EXPECT_LE(packing.pages[0].width, 480);
  EXPECT_LE(packing.pages[0].height, 480);
}

TEST(Packing, IsRepeatable) {
  std::mt19937 random(3);
  std::vector<PackShape> shapes;
  for (int i = 0; i < 500; ++i) shapes.push_back(disc(5 + static_cast<int>(random() % 60)));
  const Packing a = pack_shapes(shapes, 1024), b = pack_shapes(shapes, 1024);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    EXPECT_EQ(a.placements[i].x, b.placements[i].x);
    EXPECT_EQ(a.placements[i].y, b.placements[i].y);
    EXPECT_EQ(a.placements[i].page, b.placements[i].page);
  }
}

}  // namespace
}  // namespace gpvc
