#include <gtest/gtest.h>

#include "io/mesh.h"

namespace gpvc::io {
namespace {

//   3---2
//   | / |
//   0---1
const Mesh kSquare{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};

TEST(MeshTopology, SquareHasOneBoundaryLoopOfFourEdges) {
  const MeshTopology t = mesh_topology(kSquare);
  EXPECT_EQ(t.components, 1u);
  EXPECT_EQ(t.boundary_edges, 4u);
  EXPECT_EQ(t.boundary_loops, 1u);
  EXPECT_EQ(t.nonmanifold_faces + t.degenerate_faces + t.unused_vertices, 0u);
}

TEST(MeshTopology, TetrahedronIsClosed) {
  const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  EXPECT_EQ(mesh_topology(mesh).boundary_edges, 0u);
  EXPECT_EQ(mesh_topology(mesh).components, 1u);
}

TEST(MeshTopology, CountsTheThirdFaceOnAnEdge) {
  Mesh fan = kSquare;
  fan.positions.push_back({0, 0, 1});
  fan.faces.push_back({0, 2, 4});
  EXPECT_EQ(mesh_topology(fan).nonmanifold_faces, 1u);
}

TEST(MeshTopology, CountsDegenerateFacesUnusedVerticesAndComponents) {
  Mesh mesh = kSquare;
  mesh.faces.push_back({1, 1, 2});
  for (int i = 0; i < 4; ++i) mesh.positions.push_back({5.0 + i, 5.0 * i * i, 0});
  mesh.faces.push_back({4, 5, 6});
  const MeshTopology t = mesh_topology(mesh);
  EXPECT_EQ(t.degenerate_faces, 1u);
  EXPECT_EQ(t.unused_vertices, 1u);
  EXPECT_EQ(t.components, 2u);
  EXPECT_EQ(t.boundary_loops, 2u);
}

}  // namespace
}  // namespace gpvc::io
