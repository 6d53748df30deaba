#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>
#include <set>

#include "labeling/labeling.h"

namespace gpvc::labeling {
namespace {

using Edges = std::vector<std::array<std::uint32_t, 2>>;

Edges edges_of(std::vector<Triangle> faces) {
  Mesh mesh;
  for (const Triangle& face : faces)
    for (const std::uint32_t vertex : face)
      if (vertex >= mesh.positions.size()) mesh.positions.resize(vertex + 1);
  mesh.faces = std::move(faces);
  return face_graph(mesh).edges;
}

TEST(FaceGraph, EmptyMeshHasNone) { EXPECT_TRUE(edges_of({}).empty()); }

TEST(FaceGraph, TetrahedronIsComplete) {
  EXPECT_EQ(edges_of({{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}),
            (Edges{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}));
}

TEST(FaceGraph, FlippedNeighbourCounts) { EXPECT_EQ(edges_of({{0, 1, 2}, {0, 1, 3}}), (Edges{{0, 1}})); }

TEST(FaceGraph, SharedVertexIsNoEdge) { EXPECT_TRUE(edges_of({{0, 1, 2}, {0, 3, 4}}).empty()); }

// Faces on the edge 0-1, like pages of a book: all pairs of four, and each with the next three of more.
TEST(FaceGraph, FacesAroundANonManifoldEdgeAreNeighbours) {
  EXPECT_EQ(edges_of({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}}),
            (Edges{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}));
  EXPECT_EQ(edges_of({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}, {0, 1, 6}}),
            (Edges{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {1, 4}, {2, 3}, {2, 4}, {3, 4}}));
}

// Both sides of a wall are faces, one after the other, as some programs write them: the fronts are neighbours.
TEST(FaceGraph, FrontsOfADoubledSurfaceAreNeighbours) {
  const Edges edges = edges_of({{0, 1, 2}, {0, 2, 1}, {0, 2, 3}, {0, 3, 2}});
  EXPECT_TRUE(std::ranges::count(edges, std::array<std::uint32_t, 2>{0, 2}) == 1);
  EXPECT_TRUE(std::ranges::count(edges, std::array<std::uint32_t, 2>{1, 3}) == 1);
}

TEST(FaceGraph, DuplicateFacesAreOnePair) {
  EXPECT_EQ(edges_of({{0, 1, 2}, {0, 1, 2}}), (Edges{{0, 1}}));
  EXPECT_EQ(edges_of({{0, 1, 2}, {2, 1, 0}}), (Edges{{0, 1}}));
}

TEST(FaceGraph, DegenerateFaces) {
  // Face 1 is the edge 0-1 there and back; it neighbours face 0 once and never itself. Face 2 is a single vertex.
  EXPECT_EQ(edges_of({{0, 1, 2}, {0, 1, 0}, {1, 1, 1}}), (Edges{{0, 1}}));
}

/// Straight from the definition.
Edges brute_force(const std::vector<Triangle>& faces) {
  std::set<std::array<std::uint32_t, 2>> pairs;
  const auto has_edge = [&](std::size_t face, std::uint32_t a, std::uint32_t b) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t x = faces[face][i], y = faces[face][(i + 1) % 3];
      if ((x == a && y == b) || (x == b && y == a)) return true;
    }
    return false;
  };
  for (std::uint32_t f = 0; f < faces.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = faces[f][i], b = faces[f][(i + 1) % 3];
      if (a == b) continue;
      std::size_t found = 0;
      for (std::uint32_t g = f + 1; g < faces.size() && found < kFaceGraphReach; ++g)
        if (has_edge(g, a, b)) {
          pairs.insert({f, g});
          ++found;
        }
    }
  return {pairs.begin(), pairs.end()};
}

TEST(FaceGraph, RandomSoupsMatchTheDefinitionForAnyNumberOfThreads) {
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    std::uniform_int_distribution<std::uint32_t> vertex(0, 4 + static_cast<std::uint32_t>(round));
    std::vector<Triangle> faces(static_cast<std::size_t>(3 * round));
    for (Triangle& face : faces) face = {vertex(random), vertex(random), vertex(random)};
    const Edges expected = brute_force(faces);
    EXPECT_EQ(edges_of(faces), expected);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(edges_of(faces), expected);
  }
}

}  // namespace
}  // namespace gpvc::labeling
