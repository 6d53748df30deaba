// Reads the geometry of GLB and glTF. https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
//
// Positions are taken through the nodes of the file's scene, as it asks: y is up then. Models of ours keep the axes and
// the offset of the mesh they were made from. Vertices at one position become one, since writers repeat them along the
// seams of textures.
#include "io/meshes/gltf_nodes.h"
#include "io/meshes/merged_vertices.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::io {

Mesh read_gltf_mesh(const std::filesystem::path& file) {
  const tinygltf::Model model = parse_gltf(file);
  Mesh mesh;
  MergedVertices vertices(mesh.positions);
  std::size_t others = 0;
  for_each_primitive(file, model, GltfOffset::added,
                     [&](const tinygltf::Primitive& primitive, const GltfMatrix& world) {
                       const AccessorView positions = positions_of(file, model, primitive);
                       std::vector<std::uint32_t> numbers(positions.count);
                       for (std::size_t i = 0; i < positions.count; ++i)
                         numbers[i] = vertices.add(placed(world, positions, i));
                       const bool mirrored = mirrors(world);
                       if (!for_each_triangle(file, model, primitive, positions.count,
                                              [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                                                if (mirrored) std::swap(b, c);
                                                mesh.faces.push_back({numbers[a], numbers[b], numbers[c]});
                                              }))
                         ++others;
                     });
  if (others > 0) mesh.warnings.push_back(std::to_string(others) + " primitives of points or lines are left out");
  return mesh;
}

}  // namespace gpvc::io
