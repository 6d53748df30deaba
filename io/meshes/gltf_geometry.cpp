#include "io/meshes/gltf_geometry.h"

#include <utility>

namespace gpvc::io {
namespace {

/// Faces by page, in input order within a page: a counting sort.
std::vector<FaceId> faces_by_page(const TexturedModel& model, std::size_t page_count,
                                  std::vector<std::size_t>& page_begin) {
  page_begin.assign(page_count + 1, 0);
  for (const std::uint32_t page : model.face_page)
    if (page != kNoPage) ++page_begin[page + 1];
  for (std::size_t page = 0; page < page_count; ++page) page_begin[page + 1] += page_begin[page];
  std::vector<std::size_t> next(page_begin.begin(), page_begin.end() - 1);
  std::vector<FaceId> faces(page_begin.back());
  for (std::size_t f = 0; f < model.face_page.size(); ++f)
    if (const std::uint32_t page = model.face_page[f]; page != kNoPage)
      faces[next[page]++] = FaceId{static_cast<std::uint32_t>(f)};
  return faces;
}

}  // namespace

// Vertices with one texture coordinate form a list, newest first; charts share few, so lists are short.
GltfGeometry split_by_page(const TexturedModel& model, std::size_t page_count) {
  constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  GltfGeometry out;
  std::vector<std::size_t> page_begin;
  out.faces = faces_by_page(model, page_count, page_begin);
  out.indices.reserve(3 * out.faces.size());
  std::vector<std::uint32_t> newest(model.texcoords.size(),
                                    kNone);  // by texture coordinate: last vertex with it
  std::vector<std::uint32_t> older;          // by vertex: the one before it in that list
  for (std::size_t page = 0; page < page_count; ++page) {
    if (page_begin[page] == page_begin[page + 1]) continue;
    GltfPrimitive primitive{static_cast<std::uint32_t>(page), out.vertices.size(), 0, out.indices.size(), 0};
    for (std::size_t i = page_begin[page]; i < page_begin[page + 1]; ++i) {
      const std::size_t face = index(out.faces[i]);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t position = model.mesh->faces[face][corner];
        const std::uint32_t texcoord = model.face_texcoords[face][corner];
        std::uint32_t vertex = newest[texcoord];
        while (vertex != kNone && vertex >= primitive.first_vertex && out.vertices[vertex].position != position)
          vertex = older[vertex];
        if (vertex == kNone || vertex < primitive.first_vertex) {
          vertex = static_cast<std::uint32_t>(out.vertices.size());
          out.vertices.push_back({position, texcoord});
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
