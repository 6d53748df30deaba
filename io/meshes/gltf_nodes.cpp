#include "io/meshes/gltf_nodes.h"

#include <algorithm>

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

constexpr GltfMatrix kGltfIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

GltfMatrix product(const GltfMatrix& a, const GltfMatrix& b) {
  GltfMatrix m{};
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t k = 0; k < 4; ++k) m[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return m;
}

/// Translation times rotation times scale, or the matrix that is stated.
GltfMatrix matrix_of(const tinygltf::Node& node, GltfOffset use) {
  GltfMatrix m = kGltfIdentity;
  if (const std::optional<WorldPoint> offset = offset_of(node)) {
    if (use == GltfOffset::left) return m;
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

/// The nodes that no other one holds, or those that the scene names.
std::vector<int> roots_of(const fs::path& file, const tinygltf::Model& model) {
  if (!model.scenes.empty()) return element_at(file, model.scenes, std::max(0, model.defaultScene), "scene").nodes;
  std::vector<bool> child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes)
    for (const int number : node.children)
      if (number >= 0 && static_cast<std::size_t>(number) < child.size())
        child[static_cast<std::size_t>(number)] = true;
  std::vector<int> roots;
  for (std::size_t n = 0; n < child.size(); ++n)
    if (!child[n]) roots.push_back(static_cast<int>(n));
  return roots;
}

}  // namespace

void for_each_primitive(const fs::path& file, const tinygltf::Model& model, GltfOffset offset,
                        const std::function<void(const tinygltf::Primitive&, const GltfMatrix& world)>& add) {
  struct Placed {
    int node;
    GltfMatrix world;  ///< of the node above
  };
  std::vector<bool> visited(model.nodes.size(), false);
  // Nodes are listed and not visited in turn by calls of calls: a file may hold a long chain. The last is the next.
  std::vector<Placed> open;
  const auto list = [&open](const std::vector<int>& nodes, const GltfMatrix& world) {
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) open.push_back({*node, world});
  };
  list(roots_of(file, model), kGltfIdentity);
  while (!open.empty()) {
    const Placed next = open.back();
    open.pop_back();
    const tinygltf::Node& node = element_at(file, model.nodes, next.node, "node");
    if (visited[static_cast<std::size_t>(next.node)])
      throw InputError(file, "node " + std::to_string(next.node), "has two parents, expected a tree");
    visited[static_cast<std::size_t>(next.node)] = true;
    const GltfMatrix world = product(next.world, matrix_of(node, offset));
    list(node.children, world);
    if (node.mesh < 0) continue;
    for (const tinygltf::Primitive& primitive : element_at(file, model.meshes, node.mesh, "mesh").primitives)
      add(primitive, world);
  }
}

WorldPoint placed(const GltfMatrix& m, const AccessorView& positions, std::size_t element) {
  const double x = positions.component(element, 0), y = positions.component(element, 1),
               z = positions.component(element, 2);
  return {m[0] * x + m[4] * y + m[8] * z + m[12], m[1] * x + m[5] * y + m[9] * z + m[13],
          m[2] * x + m[6] * y + m[10] * z + m[14]};
}

bool mirrors(const GltfMatrix& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
             m[8] * (m[1] * m[6] - m[2] * m[5]) <
         0;
}

}  // namespace gpvc::io
