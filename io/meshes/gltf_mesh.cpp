// Reads the geometry of GLB and glTF. https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
//
// Positions are taken through the nodes of the file's scene, as it asks: y is up then. Models of ours keep the axes and
// the offset of the mesh they were made from. Vertices at one position become one, since writers repeat them along the
// seams of textures.
#include <algorithm>
#include <array>

#include "io/meshes/gltf_reader.h"
#include "io/meshes/merged_vertices.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::io {

namespace {

/// 4 x 4, column after column, as glTF has them.
using GltfMatrix = std::array<double, 16>;

constexpr GltfMatrix kGltfIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

GltfMatrix product(const GltfMatrix& a, const GltfMatrix& b) {
  GltfMatrix m{};
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t k = 0; k < 4; ++k) m[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return m;
}

/// Translation times rotation times scale, or the matrix that is stated.
GltfMatrix matrix_of(const tinygltf::Node& node) {
  GltfMatrix m = kGltfIdentity;
  if (const std::optional<WorldPoint> offset = offset_of(node)) {
    m[12] = offset->x;
    m[13] = offset->y;
    m[14] = offset->z;
    return m;
  }
  if (node.matrix.size() == 16) {
    std::ranges::copy(node.matrix, m.begin());
    return m;
  }
  if (node.rotation.size() == 4) {
    const double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
    m = {1 - 2 * (y * y + z * z),
         2 * (x * y + z * w),
         2 * (x * z - y * w),
         0,
         2 * (x * y - z * w),
         1 - 2 * (x * x + z * z),
         2 * (y * z + x * w),
         0,
         2 * (x * z + y * w),
         2 * (y * z - x * w),
         1 - 2 * (x * x + y * y),
         0,
         0,
         0,
         0,
         1};
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (node.scale.size() == 3)
      for (std::size_t row = 0; row < 3; ++row) m[4 * axis + row] *= node.scale[axis];
    if (node.translation.size() == 3) m[12 + axis] = node.translation[axis];
  }
  return m;
}

class GltfMeshReader {
 public:
  explicit GltfMeshReader(const std::filesystem::path& file)
      : file_(file), model_(parse_gltf(file)), vertices_(mesh_.positions) {}

  Mesh read() {
    std::vector<int> roots;
    if (model_.scenes.empty()) {
      std::vector<bool> child(model_.nodes.size(), false);
      for (const tinygltf::Node& node : model_.nodes)
        for (const int number : node.children)
          if (number >= 0 && static_cast<std::size_t>(number) < child.size())
            child[static_cast<std::size_t>(number)] = true;
      for (std::size_t n = 0; n < child.size(); ++n)
        if (!child[n]) roots.push_back(static_cast<int>(n));
    } else {
      roots = element_at(file_, model_.scenes, std::max(0, model_.defaultScene), "scene").nodes;
    }
    visited_.assign(model_.nodes.size(), false);
    for (const int root : roots) add_nodes(root);
    if (others_ > 0) mesh_.warnings.push_back(std::to_string(others_) + " primitives of points or lines are left out");
    return std::move(mesh_);
  }

 private:
  struct Placed {
    int node;
    GltfMatrix world;
  };

  /// A node and all below it. They are listed and not visited in turn by calls of calls: a file may hold a long chain.
  void add_nodes(int root) {
    std::vector<Placed> open{{root, kGltfIdentity}};
    while (!open.empty()) {
      const Placed next = open.back();
      open.pop_back();
      const tinygltf::Node& node = element_at(file_, model_.nodes, next.node, "node");
      if (visited_[static_cast<std::size_t>(next.node)])
        throw InputError(file_, "node " + std::to_string(next.node), "has two parents, expected a tree");
      visited_[static_cast<std::size_t>(next.node)] = true;
      const GltfMatrix world = product(next.world, matrix_of(node));
      for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) open.push_back({*child, world});
      if (node.mesh < 0) continue;
      for (const tinygltf::Primitive& primitive : element_at(file_, model_.meshes, node.mesh, "mesh").primitives)
        add_primitive(primitive, world);
    }
  }

  void add_primitive(const tinygltf::Primitive& primitive, const GltfMatrix& m) {
    const AccessorView positions = positions_of(file_, model_, primitive);
    // A mirroring node turns its triangles over.
    const double determinant =
        m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) + m[8] * (m[1] * m[6] - m[2] * m[5]);
    std::vector<std::uint32_t> numbers(positions.count);
    for (std::size_t i = 0; i < positions.count; ++i) {
      const double x = positions.component(i, 0), y = positions.component(i, 1), z = positions.component(i, 2);
      const WorldPoint p{m[0] * x + m[4] * y + m[8] * z + m[12], m[1] * x + m[5] * y + m[9] * z + m[13],
                         m[2] * x + m[6] * y + m[10] * z + m[14]};
      numbers[i] = vertices_.add(p);
    }
    if (!for_each_triangle(file_, model_, primitive, positions.count,
                           [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                             if (determinant < 0) std::swap(b, c);
                             mesh_.faces.push_back({numbers[a], numbers[b], numbers[c]});
                           }))
      ++others_;
  }

  const std::filesystem::path& file_;
  const tinygltf::Model model_;
  Mesh mesh_;
  MergedVertices vertices_;
  std::vector<bool> visited_;
  std::size_t others_ = 0;
};

}  // namespace

Mesh read_gltf_mesh(const std::filesystem::path& file) { return GltfMeshReader(file).read(); }

}  // namespace gpvc::io
