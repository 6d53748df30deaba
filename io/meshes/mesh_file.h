// One function a mesh format; read_mesh picks by content. Adding a format adds a line here and a file.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/text_scan.h"
#include "io/mesh.h"
#include "io/scene.h"
#include "io/textured_model.h"

namespace gpvc::io {

/// Texture of a PLY, as MeshLab and OpenMVS write it: pages in comments "TextureFile NAME", the texture coordinates of a
/// face's corners in a list "texcoord", with v upwards, and the number of its page in "texnumber".
struct PlyTexture {
  std::vector<std::string> files;
  /// Per triangle and corner; not finite where the file states none.
  std::vector<std::array<TexCoord, 3>> corners;
  std::vector<std::int64_t> page;  ///< per triangle, as it stands; 0 where the file states none
  std::vector<TexCoord> vertices;  ///< per vertex, as it stands; empty where the file states none
};

/// \pre bytes start with "ply" and a line end. Polygons are fans. Fills `texture` unless it is null.
Mesh read_ply(const std::filesystem::path& file, std::string_view bytes, PlyTexture* texture = nullptr);

/// Texture of an OBJ.
struct ObjTexture {
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  std::vector<TexCoord> texcoords;                 ///< with v downwards, unlike the file's
  bool states_all = false;                         ///< fill `stated`
  std::vector<std::array<double, 2>> stated;       ///< u and v as they stand, v upwards
  std::vector<Triangle> corners;                   ///< per triangle; of corners without one, kNone
  std::map<std::string, std::uint32_t> materials;  ///< the numbers of the materials in use
  std::vector<std::uint32_t> material;             ///< per triangle; a number above all of them where there is none
  std::vector<std::string> libraries;              ///< names of material files: one with blanks, or several
};

/// The name behind the keyword of an OBJ's or MTL's line: it may hold blanks, and a comment may follow.
inline std::string_view name_behind(std::string_view line) { return trimmed(line.substr(0, line.find(" #"))); }

/// Polygons are fans. Fills `texture` unless it is null.
Mesh read_obj(const std::filesystem::path& file, std::string_view bytes, ObjTexture* texture = nullptr);

bool is_stl(std::string_view bytes);
/// \pre is_stl(bytes)
Mesh read_stl(const std::filesystem::path& file, std::string_view bytes);

bool is_off(std::string_view bytes);
/// \pre is_off(bytes)
Mesh read_off(const std::filesystem::path& file, std::string_view bytes);

/// Reads the file itself, and those with its buffers.
Mesh read_gltf_mesh(const std::filesystem::path& file);

/// To be called after face `face` of the file was split into `triangles` faces, or left out: records Mesh::source_face,
/// which stays empty as long as every face is one triangle.
void note_source(Mesh& mesh, std::size_t triangles, std::size_t face);

/// Adds a warning unless count is 0. Faces of one or two vertices are what modellers keep of edges.
void warn_of_lines(Mesh& mesh, std::size_t count, const std::string& first);

/// Retriangulates polygons that were added as fans and whose fan turns a triangle over, and `texcoords`, unless it is
/// empty, the same way. \pre all vertices are read
void recut_concave(Mesh& mesh, std::span<Triangle> texcoords = {});

/// False where a coordinate is not finite or exceeds kMostCoordinate.
inline bool has_place(const WorldPoint& p) {
  const auto is_coordinate = [](double v) { return std::abs(v) <= kMostCoordinate; };  // false for NaN
  return is_coordinate(p.x) && is_coordinate(p.y) && is_coordinate(p.z);
}

/// Gives vertices without a place (a coordinate is not finite or exceeds kMostCoordinate) that of another vertex, and has
/// each face that uses one name another of its corners in its stead: a face without area, which nothing shows. Numbers of
/// vertices and faces stay. Warns of both. Throws InputError where no face is left with a place. O(vertices + faces).
void settle_places(const std::filesystem::path& file, Mesh& mesh);

/// Throws InputError for a mesh without faces: says whether it is a point cloud.
void refuse_faceless(const std::filesystem::path& file, const Mesh& mesh);

/// FaceId and vertex indices are 32 bits wide, and the last value means "none".
inline constexpr std::uint64_t kMaxElements = 0xFFFFFFFEu;

}  // namespace gpvc::io
