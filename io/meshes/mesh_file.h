// One function a mesh format; read_mesh picks by content. Adding a format adds a line here and a file.
#pragma once

#include <filesystem>
#include <string_view>

#include "io/scene.h"

namespace gpvc::io {

/// \pre bytes start with "ply" and a line end
Mesh read_ply(const std::filesystem::path& file, std::string_view bytes);

Mesh read_obj(const std::filesystem::path& file, std::string_view bytes);

/// To be called after face `face` of the file was split into `triangles` faces: records Mesh::source_face, which stays
/// empty as long as every face is one triangle.
void note_source(Mesh& mesh, std::size_t triangles, std::size_t face);

/// Retriangulates polygons that were added as fans and whose fan turns a triangle over. \pre all vertices are read
void recut_concave(Mesh& mesh);

/// FaceId and vertex indices are 32 bits wide, and the last value means "none".
inline constexpr std::uint64_t kMaxElements = 0xFFFFFFFEu;

}  // namespace gpvc::io
