#include "io/meshes/gltf_geometry.h"

#include <utility>

#include "io/grouping.h"

namespace gpvc::io {

// Vertices with one texture coordinate form a list, newest first; charts share few, so lists are short.
GltfGeometry split_by_page(const TexturedModel& model, std::size_t page_count, const PhotoTable* photos) {
  constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  GltfGeometry out;
  Grouped<FaceId> by_page = group_items<FaceId>(page_count, [&](const auto& add) {
    for (std::size_t f = 0; f < model.face_page.size(); ++f)
      if (model.face_page[f] != kNoPage) add(model.face_page[f], FaceId{static_cast<std::uint32_t>(f)});
  });
  out.faces = std::move(by_page.items);
  out.indices.reserve(3 * out.faces.size());
  std::vector<std::uint32_t> newest(model.texcoords.size(), kNone);  // by texture coordinate: its last vertex
  std::vector<std::uint32_t> older;                                  // by vertex: the one before it in that list
  for (std::size_t page = 0; page < page_count; ++page) {
    if (by_page.first[page] == by_page.first[page + 1]) continue;
    GltfPrimitive primitive{static_cast<std::uint32_t>(page), out.vertices.size(), 0, out.indices.size(), 0};
    for (std::size_t i = by_page.first[page]; i < by_page.first[page + 1]; ++i) {
      const std::size_t face = index(out.faces[i]);
      const std::uint32_t photo = photos != nullptr ? photos->of_face[face] : 0;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t position = model.mesh->faces[face][corner];
        const std::uint32_t texcoord = model.face_texcoords[face][corner];
        const auto is_same = [&](const GltfVertex& other) {
          return other.position == position && other.photo == photo;
        };
        std::uint32_t vertex = newest[texcoord];
        while (vertex != kNone && vertex >= primitive.first_vertex && !is_same(out.vertices[vertex]))
          vertex = older[vertex];
        if (vertex == kNone || vertex < primitive.first_vertex) {
          vertex = static_cast<std::uint32_t>(out.vertices.size());
          out.vertices.push_back({position, texcoord, photo});
          older.push_back(std::exchange(newest[texcoord], vertex));
        }
        out.indices.push_back(vertex - static_cast<std::uint32_t>(primitive.first_vertex));
      }
    }
    primitive.vertex_count = out.vertices.size() - primitive.first_vertex;
    primitive.index_count = out.indices.size() - primitive.first_index;
    out.primitives.push_back(primitive);
  }
  return out;
}

}  // namespace gpvc::io
