// Vertices and triangles of a textured mesh as glTF has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/textured_model.h"

namespace gpvc::io {

/// A corner of the mesh on a page.
struct GltfVertex {
  std::uint32_t position, texcoord, photo;  ///< photo: row of a PhotoTable, 0 without one
};

/// The triangles of one page: ranges of the vertex and index arrays.
struct GltfPrimitive {
  std::uint32_t page = 0;
  std::size_t first_vertex = 0, vertex_count = 0;
  std::size_t first_index = 0, index_count = 0;
};

struct GltfGeometry {
  std::vector<GltfVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< within their primitive
  std::vector<GltfPrimitive> primitives;
  std::vector<FaceId> faces;  ///< of every triangle
};

/// One vertex for every distinct (position, texture coordinate, photo) of a page, numbered in the order of first use; pages
/// without a face have no primitive, faces without a page are left out. O(faces). \param photos may be null
GltfGeometry split_by_page(const TexturedModel& model, std::size_t page_count, const PhotoTable* photos);

}  // namespace gpvc::io
