#include "atlas/packing/packing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "atlas/baking/pages.h"

namespace gpvc::atlas {
namespace {

/// Marks the cells of a placed shape on its page, checks that they were free, and returns their number.
std::size_t paint(const PackShape& shape, const Placement& at, const Packing& packing,
                  std::vector<std::vector<std::uint8_t>>& pages) {
  const PageSize& size = packing.pages[at.page];
  const ChartPlace place{at.page, at.x, at.y, at.turns, shape.width, shape.height, 0, 0};
  std::size_t cells = 0;
  for (const CellRun& run : shape.runs) {
    for (int x = run.first; x < run.first + run.length; ++x) {
      const auto [px, py] = place.texel(x, run.row);
      const bool inside = px >= 0 && py >= 0 && px < size.width && py < size.height;
      EXPECT_TRUE(inside);
      if (!inside) return cells;
      auto& cell = pages[at.page][static_cast<std::size_t>(py) * static_cast<std::size_t>(size.width) +
                                  static_cast<std::size_t>(px)];
      EXPECT_EQ(cell, 0) << "overlap at " << px << " " << py;
      cell = 1;
      ++cells;
    }
  }
  return cells;
}

/// The share of the pages' cells that shapes cover. Fails on any overlap.
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

/// A shape that fills its whole box.
PackShape box_shape(int width, int height) {
  PackShape shape{width, height, {}};
  for (int row = 0; row < height; ++row) shape.runs.push_back({row, 0, width});
  return shape;
}

PackShape disc(int radius) {
  PackShape shape{2 * radius, 2 * radius, {}};
  for (int row = 0; row < 2 * radius; ++row) {
    const double y = std::min(std::abs(row - radius), std::abs(row + 1 - radius));
    const double half = std::sqrt(std::max(0.0, radius * double(radius) - y * y));
    const int first = static_cast<int>(radius - half), last = static_cast<int>(radius + half - 1e-9);
    shape.runs.push_back({row, first, last - first + 1});
  }
  return shape;
}

/// An L, whose box leaves room for a small square.
PackShape corner(int edge) {
  PackShape shape{edge, edge, {}};
  for (int row = 0; row < edge; ++row) shape.runs.push_back({row, 0, row < edge / 2 ? edge / 2 : edge});
  return shape;
}

/// Some rows have two runs, like those of a chart with a hole.
PackShape frame(int edge) {
  PackShape shape{edge, edge, {}};
  for (int row = 0; row < edge; ++row) {
    if (row == 0 || row == edge - 1) {
      shape.runs.push_back({row, 0, edge});
    } else {
      shape.runs.push_back({row, 0, 1});
      shape.runs.push_back({row, edge - 1, 1});
    }
  }
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

/* 100 x 25 cells, twice: upright the page of 125 has room for four rows; the tall one must turn. */
TEST(Packing, TurnsWhatDoesNotFitUpright) {
  const std::vector<PackShape> shapes{box_shape(100, 99), box_shape(25, 100), box_shape(100, 25)};
  const Packing packing = pack_shapes(shapes, 125);
  EXPECT_EQ(packing.pages.size(), 1u);
  EXPECT_GT(check(shapes, packing, 125), 0.85);
}

TEST(Packing, SquaresFillTheCornersOfShapes) {
  /*  a . b .
      aa. bb.   four L of 16 and four squares of 8: exactly 64 x 16, if the squares go into the corners */
  std::vector<PackShape> shapes(4, corner(16));
  shapes.insert(shapes.end(), 4, box_shape(8, 8));
  const Packing packing = pack_shapes(shapes, 32);
  EXPECT_EQ(packing.pages.size(), 1u);
  EXPECT_DOUBLE_EQ(check(shapes, packing, 32), 1.0);
}

TEST(Packing, SmallShapesLieWithinTheHolesOfLargeOnes) {
  std::vector<PackShape> shapes{frame(30)};
  shapes.insert(shapes.end(), 49, box_shape(4, 4));
  const Packing packing = pack_shapes(shapes, 30);
  EXPECT_EQ(packing.pages.size(), 1u);
  check(shapes, packing, 30);
}

TEST(Packing, BoxesOfAnySizeNeverOverlap) {
  std::mt19937 random(7);
  std::vector<PackShape> shapes;
  for (int i = 0; i < 20000; ++i) {
    const double size = std::exp(std::uniform_real_distribution<>(std::log(3.0), std::log(40.0))(random));
    const double aspect = std::exp(std::uniform_real_distribution<>(-0.9, 0.9)(random));
    shapes.push_back(box_shape(static_cast<int>(size * aspect) + 1, static_cast<int>(size / aspect) + 1));
  }
  const Packing packing = pack_shapes(shapes, 1024);
  EXPECT_GT(packing.pages.size(), 2u);
  EXPECT_GT(check(shapes, packing, 1024), 0.85);
}

/// Checks every cell of every page for many random sets of shapes, in all quarter turns.
TEST(Packing, ShapesOfAnyOutlineNeverOverlap) {
  std::array<int, 4> turns{};
  for (unsigned seed = 0; seed < 12; ++seed) {
    std::mt19937 random(11 + seed);
    std::vector<PackShape> shapes;
    for (int i = 0; i < 700; ++i) {
      const int size = 1 + static_cast<int>(std::exp(std::uniform_real_distribution<>(0.0, 3.6)(random)));
      shapes.push_back(i % 4 == 0   ? disc(size)
                       : i % 4 == 1 ? corner(2 * size)
                       : i % 4 == 2 ? frame(size + 1)
                                    : box_shape(size, 2 * size));
    }
    const int page = 96 + static_cast<int>(random() % 160);
    const Packing packing = pack_shapes(shapes, page);
    EXPECT_GT(check(shapes, packing, page), 0.5);
    for (const auto& p : packing.placements) ++turns[static_cast<std::size_t>(p.turns)];
  }
  for (const int n : turns) EXPECT_GT(n, 100);
}

TEST(Packing, OversizePageCountIsNearTheArea) {
  const std::vector<PackShape> shapes(9, box_shape(125, 125));
  const Packing packing = pack_shapes(shapes, 250);
  EXPECT_EQ(packing.pages.size(), 3u);
  check(shapes, packing, 250);
  EXPECT_EQ(packing.pages.back().width, 125);
  EXPECT_EQ(packing.pages.back().height, 125);
}

TEST(Packing, SmallScenesGiveSmallNearSquarePages) {
  const std::vector<PackShape> shapes(100, box_shape(10, 10));
  const Packing packing = pack_shapes(shapes, 2048);
  ASSERT_EQ(packing.pages.size(), 1u);
  EXPECT_LE(packing.pages[0].width, 120);
  EXPECT_LE(packing.pages[0].height, 120);
}

// Pages of 8192 x 8192 cells are so large that attempts follow each other two by two.
TEST(Packing, TheBestAttemptIsTakenHoweverManyRunAtOnce) {
  std::vector<PackShape> shapes;
  for (int i = 0; i < 40; ++i) shapes.push_back(i % 2 == 0 ? disc(2 + i % 7) : box_shape(3 + i % 5, 4 + i % 11));
  const Packing together = pack_shapes(shapes, 256), in_turn = pack_shapes(shapes, 8192);
  ASSERT_EQ(in_turn.pages.size(), 1u);
  EXPECT_EQ(in_turn.pages[0].width, together.pages.at(0).width);
  EXPECT_EQ(in_turn.pages[0].height, together.pages[0].height);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    EXPECT_EQ(in_turn.placements[i].x, together.placements[i].x) << i;
    EXPECT_EQ(in_turn.placements[i].y, together.placements[i].y) << i;
    EXPECT_EQ(in_turn.placements[i].turns, together.placements[i].turns) << i;
  }
}

TEST(Packing, PagesAscendByRank) {
  std::mt19937 random(5);
  std::vector<PackShape> shapes;
  for (int i = 0; i < 400; ++i) {
    shapes.push_back(disc(10 + static_cast<int>(random() % 90)));
    shapes.back().rank = static_cast<std::uint32_t>(random() % 50);
  }
  const Packing packing = pack_shapes(shapes, 512);
  check(shapes, packing, 512);
  ASSERT_GT(packing.pages.size(), 4u);
  std::vector<std::uint32_t> least(packing.pages.size(), 50), most(packing.pages.size(), 0);
  double covered = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const std::uint32_t page = packing.placements[i].page;
    least[page] = std::min(least[page], shapes[i].rank);
    most[page] = std::max(most[page], shapes[i].rank);
    for (const CellRun& run : shapes[i].runs) covered += run.length;
  }
  // Shapes fill gaps of the page before their own, and those of a page that is not enough go on to the next one.
  for (std::size_t p = 3; p < least.size(); ++p) EXPECT_LE(most[p - 3], least[p]);
  EXPECT_LE(packing.pages.size(), std::ceil(covered / (0.72 * 512 * 512)));
}

TEST(Packing, IsRepeatable) {
  std::mt19937 random(3);
  std::vector<PackShape> shapes;
  for (int i = 0; i < 500; ++i) shapes.push_back(disc(5 + static_cast<int>(random() % 60)));
  const Packing a = pack_shapes(shapes, 256), b = pack_shapes(shapes, 256);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    EXPECT_EQ(a.placements[i].x, b.placements[i].x);
    EXPECT_EQ(a.placements[i].y, b.placements[i].y);
    EXPECT_EQ(a.placements[i].page, b.placements[i].page);
  }
}

}  // namespace
}  // namespace gpvc::atlas
