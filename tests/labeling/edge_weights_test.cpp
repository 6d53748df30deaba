#include <gtest/gtest.h>
#include <cmath>

#include "labeling/labeling.h"

namespace gpvc::labeling {
namespace {

// Two triangles lie flat on edge 1-2 (length sqrt(2)); the third stands upright on edge 2-3 (length 1).
//
//   3---2
//   | \ |    edge 0-1: length 1, edge 1-3 the diagonal
//   0---1
Mesh folded() { return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 1, 1}}, {{0, 1, 3}, {1, 2, 3}, {3, 2, 4}}}; }

FaceGraph weighed(EdgeWeights weights) {
  const Mesh mesh = folded();
  FaceGraph graph = face_graph(mesh);
  weigh_edges(mesh, weights, graph);
  return graph;
}

TEST(EdgeWeights, UniformHasNone) { EXPECT_TRUE(weighed(EdgeWeights::uniform).weights.empty()); }

TEST(EdgeWeights, LengthIsRelativeToTheMean) {
  const FaceGraph graph = weighed(EdgeWeights::length);
  ASSERT_EQ(graph.weights.size(), 2u);
  const double mean = (std::sqrt(2.0) + 1) / 2;
  EXPECT_NEAR(graph.weights[0], std::sqrt(2.0) / mean, 1e-6);
  EXPECT_NEAR(graph.weights[1], 1 / mean, 1e-6);
}

TEST(EdgeWeights, FoldIsCheapAndFlatIsNot) {
  const FaceGraph graph = weighed(EdgeWeights::dihedral);
  EXPECT_NEAR(graph.weights[0], 1.0, 1e-6);
  EXPECT_NEAR(graph.weights[1], 0.5, 1e-6);  // (1 + cos 90) / 2
}

// The middle face is as well off with either view; the seam goes where it is cheap.
TEST(EdgeWeights, SeamGoesIntoTheFold) {
  CostTable table;
  table.first = {0, 1, 3, 4};
  table.views = {0, 0, 1, 1};
  table.costs = {0, 0.25f, 0, 0};
  const FaceGraph graph = weighed(EdgeWeights::dihedral);
  const Selection selection = select_views(table, graph, {}, {});
  EXPECT_EQ(selection.labels, (std::vector<ViewId>{ViewId{0}, ViewId{0}, ViewId{1}}));
  EXPECT_NEAR(selection.energy, 0.75, 1e-6);
  const Selection uniform = select_views(table, weighed(EdgeWeights::uniform), {}, {});
  EXPECT_EQ(uniform.labels, (std::vector<ViewId>{ViewId{0}, ViewId{1}, ViewId{1}}));
}

}  // namespace
}  // namespace gpvc::labeling
