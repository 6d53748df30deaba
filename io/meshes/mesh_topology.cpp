// Reports on connectivity by OpenMesh: the faces that its halfedges cannot hold are the non-manifold ones.
#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "io/mesh.h"

namespace gpvc::io {
namespace {

bool repeats_a_vertex(const Triangle& face) { return face[0] == face[1] || face[1] == face[2] || face[2] == face[0]; }

void count_boundary(const OpenMesh::TriConnectivity& mesh, MeshTopology& topology) {
  std::vector<bool> walked(mesh.n_halfedges(), false);
  for (const OpenMesh::HalfedgeHandle start : mesh.halfedges()) {
    if (!mesh.is_boundary(start) || walked[static_cast<std::size_t>(start.idx())]) continue;
    ++topology.boundary_loops;
    for (OpenMesh::HalfedgeHandle h = start; !walked[static_cast<std::size_t>(h.idx())];
         h = mesh.next_halfedge_handle(h)) {
      walked[static_cast<std::size_t>(h.idx())] = true;
      ++topology.boundary_edges;
    }
  }
}

void count_components(const OpenMesh::TriConnectivity& mesh, MeshTopology& topology) {
  std::vector<bool> reached(mesh.n_faces(), false);
  std::vector<OpenMesh::FaceHandle> front;
  for (const OpenMesh::FaceHandle seed : mesh.faces()) {
    if (reached[static_cast<std::size_t>(seed.idx())]) continue;
    ++topology.components;
    reached[static_cast<std::size_t>(seed.idx())] = true;
    front.assign(1, seed);
    while (!front.empty()) {
      const OpenMesh::FaceHandle face = front.back();
      front.pop_back();
      for (auto next = mesh.cff_iter(face); next.is_valid(); ++next) {
        if (reached[static_cast<std::size_t>(next->idx())]) continue;
        reached[static_cast<std::size_t>(next->idx())] = true;
        front.push_back(*next);
      }
    }
  }
}

}  // namespace

MeshTopology mesh_topology(const Mesh& mesh) {
  OpenMesh::TriConnectivity connectivity;
  connectivity.reserve(mesh.positions.size(), 3 * mesh.faces.size() / 2, mesh.faces.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) connectivity.add_vertex();

  MeshTopology topology;
  // OpenMesh prints a line for every complex edge; the counts say the same in one line.
  const bool printing = omerr().is_enabled();
  omerr().disable();
  for (const Triangle& face : mesh.faces) {
    if (repeats_a_vertex(face)) {
      ++topology.degenerate_faces;
      continue;
    }
    std::array<OpenMesh::VertexHandle, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = OpenMesh::VertexHandle(static_cast<int>(face[k]));
    if (!connectivity.add_face(corners.data(), 3).is_valid()) ++topology.nonmanifold_faces;
  }
  if (printing) omerr().enable();
  for (const OpenMesh::VertexHandle vertex : connectivity.vertices())
    if (connectivity.is_isolated(vertex)) ++topology.unused_vertices;
  count_boundary(connectivity, topology);
  count_components(connectivity, topology);
  return topology;
}

}  // namespace gpvc::io
