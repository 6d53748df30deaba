// Triangle meshes: reading them, and reports on how they are made.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "error.h"
#include "scene.h"

namespace gpvc::io {

/// The largest coordinate of a mesh, of either sign. Single precision sets it: ray tracing (Embree allows 1.8e18), OpenGL
/// and glTF hold positions as floats and multiply differences of two of them. Such a difference is below 2^61, and the sum of
/// three squares below 2^124, in the range of floats (2^128). In double precision, comparing two depths exactly multiplies
/// five values, each below 2^61 times a focal length: far from overflow at 2^1024.
inline constexpr double kMostCoordinate = 1e18;

/// Reads PLY (ASCII, binary little and big endian, float or double, any extra properties), OBJ, STL, OFF (ASCII), GLB or
/// glTF, told apart by content (glTF in JSON by its extension). STL and glTF repeat vertices: those at one position become
/// one. glTF is taken through its nodes, so y is up. Polygons of more than three vertices are split: as a fan where that turns no triangle over, by
/// ear clipping elsewhere; Mesh::source_face leads back to them. Groups, texture coordinates, normals, lines and points
/// of an OBJ are ignored. Faces that use a vertex whose coordinates are
/// not finite or above kMostCoordinate lose their area, and such vertices get the place of another, with a warning;
/// numbers of faces and vertices stay. Throws InputError on indices out of range, on a truncated file, and on a mesh
/// without faces that have a place. A folder is read as the mesh that its mesh_files() make together, as read_meshes() reads
/// them. O(file size).
Mesh read_mesh(const std::filesystem::path& file);

/// By the extension: a mesh whose y is up by its format.
bool is_gltf(const std::filesystem::path& file);
/// True for the extensions of meshes: .ply, .obj, .stl, .off, .glb and .gltf. No format of scenes uses them.
bool is_mesh_name(const std::filesystem::path& file);

/// The files .ply and .obj in a folder, at any depth, by their paths: the tiles that ContextCapture, DJI Terra and others
/// write; not those in results of ours. A file stands for itself. Throws InputError where the folder has none or cannot be read.
std::vector<std::filesystem::path> mesh_files(const std::filesystem::path& file_or_folder);

/// The meshes of files, in their order, read in parallel. `given`: the mesh_files() of each mesh that was given. Throws the
/// InputError of the first file that cannot be read; and where two files of one folder fill the same place, as versions of
/// one mesh do (OpenDroneMap's odm_mesh.ply and odm_25dmesh.ply, levels of detail): their boxes agree on each axis to 80 % of
/// what they span together. O(file sizes + (files of a folder)^2).
std::vector<Mesh> read_meshes(std::span<const std::vector<std::filesystem::path>> given);

/// What a mesh's positions lack to be coordinates of a reference system.
struct MeshOrigin {
  std::filesystem::path file;  ///< that states it
  std::string srs;             ///< "EPSG:32631"; empty where the file names none
  WorldPoint origin;           ///< to be added to the positions
};

/// From the metadata.xml that ContextCapture, DJI Terra and others write beside a mesh, or up to two folders above its
/// tiles; nullopt where there is none. Throws InputError.
std::optional<MeshOrigin> read_mesh_origin(const std::filesystem::path& mesh);

/// Appends `more` to `all`: its vertex and face numbers, and the polygon numbers in Mesh::source_face, continue those of
/// `all`, as if one file held both meshes. \pre together at most 2^32 - 2 vertices, faces and polygons. O(more), and
/// O(all) when the first polygons are appended.
void append_mesh(Mesh& all, const Mesh& more);

/// The connectivity of a mesh, as far as a halfedge structure can hold it.
struct MeshTopology {
  std::size_t components = 0;  ///< connected over edges, among the faces held
  std::size_t boundary_edges = 0, boundary_loops = 0;
  std::size_t nonmanifold_faces = 0;  ///< not held: on an edge that has two faces already, or oriented against them
  std::size_t degenerate_faces = 0;   ///< not held: name a vertex twice
  std::size_t unused_vertices = 0;    ///< in no face held
};

/// Counts of unusual elements; all of them stay in the mesh.
struct MeshFlaws {
  std::size_t degenerate_faces = 0;       ///< name a vertex twice
  std::size_t flat_faces = 0;             ///< three vertices in a line, or two at one position
  std::size_t duplicate_faces = 0;        ///< name the same vertices as an earlier face, in any order
  std::size_t unreferenced_vertices = 0;  ///< in no face
  std::size_t duplicate_vertices = 0;     ///< at the position of an earlier vertex
};

/// O(n log n).
MeshFlaws mesh_flaws(const Mesh& mesh);

/// A report alone, computed by OpenMesh: the arrays of Mesh stay the truth. O(faces).
MeshTopology mesh_topology(const Mesh& mesh);

}  // namespace gpvc::io
