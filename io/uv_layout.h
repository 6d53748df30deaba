// Texture coordinates that a mesh already has, and the pages that they lie on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "scene.h"
#include "textured_model.h"

namespace gpvc::io {

/// Texture coordinates as a file or a program states them.
struct StatedUv {
  struct Material {
    std::string name;           ///< may be empty
    int width = 0, height = 0;  ///< of its image, texels; 0: not known
  };
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  std::vector<std::array<double, 2>> texcoords;  ///< u and v, v upwards as in an OBJ
  std::vector<Triangle> face_texcoords;          ///< per face; kNone at a corner without any
  std::vector<std::uint32_t> face_material;      ///< per face, one of `materials`; kNone: no material
  std::vector<Material> materials;
};

/// Takes the coordinates of each corner of each face, those that are not finite as none: corners of a vertex that have the same share
/// them, in the order of the faces. \param corners three a face. O(faces).
void set_corners(std::span<const Triangle> faces, std::span<const std::array<double, 2>> corners, StatedUv& uv);

/// Of an OBJ, a GLB, a glTF or a PLY (of corners, as MeshLab and OpenMVS write them, or of vertices: s and t, u and v, texture_u and
/// texture_v), with the faces of read_mesh(): in its order, cut in the same way. Of images the sizes alone are
/// looked at; those that cannot be read have none. Throws InputError, also for other formats.
StatedUv read_uv(const std::filesystem::path& model);

/// A page of a layout.
struct UvPage {
  /// What follows "model" in the name of its file: "_0", "_NAME", ".1001" or "_NAME.1001". No two are the same, also where upper
  /// and lower case are.
  std::string suffix;
  std::string material;  ///< what OBJ and glTF call it; no two are the same
  int width = 0, height = 0;
};

/// The places of a mesh's faces on pages that are to be baked.
struct UvLayout {
  std::vector<TexCoord> texcoords;                   ///< in page units, as in TexturedModel
  std::vector<std::array<double, 2>> obj_texcoords;  ///< the same as they were stated: what an OBJ is to have
  std::vector<Triangle> face_texcoords;              ///< per face, indices into both
  std::vector<std::uint32_t> face_page;              ///< per face; kNoPage: it has no texture coordinates
  std::vector<UvPage> pages;
  bool has_udim_tiles = false;
  /// Faces beyond 0 .. 1 where no tiles are meant: they lie where a texture that repeats has them.
  std::size_t repeated_faces = 0;
};

/// How large pages are.
struct UvPageSize {
  int edge = 8192;        ///< of pages, longer one; 1 to 32768 texels
  bool as_images = true;  ///< pages whose materials have images of known size have that instead, up to 32768
};

/// Each material has pages of its own. Coordinates of 0 and more, of which some lie beyond 1, are UDIM tiles (u below 10): a
/// page each, with the number 1001 + floor(u) + 10 floor(v). Where any is negative, or above 10, textures repeat. Throws
/// InputError, which names `file`, where a face lies in two tiles, and for more than 1000 pages. O(faces + texture coordinates).
UvLayout lay_out(const StatedUv& uv, const UvPageSize& size, const std::filesystem::path& file = {"mesh"});

}  // namespace gpvc::io
