// Textured meshes: writing OBJ and glTF, reading them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "error.h"
#include "image.h"
#include "images.h"
#include "names.h"
#include "scene.h"

namespace gpvc::io {

/// Texture coordinates in page units: (0,0) top-left corner of the page, (1,1) bottom-right; glTF's convention.
struct TexCoord {
  float u = 0, v = 0;
};

/// A textured mesh in the input's face order.
struct TexturedModel {
  const Mesh* mesh = nullptr;  ///< borrowed
  std::vector<TexCoord> texcoords;
  std::vector<Triangle> face_texcoords;  ///< per face, indices into texcoords
  std::vector<std::uint32_t> face_page;  ///< per face, index into page files, or kNoPage
  /// Per texture coordinate, u and v (upwards) that an OBJ is to have, where others name the same place of the page: they lie
  /// in another tile, or floats would round them. Empty: those of `texcoords`.
  std::vector<std::array<double, 2>> obj_texcoords{};
};

/// face_page of a face without texture, whose face_texcoords mean nothing.
inline constexpr std::uint32_t kNoPage = 0xFFFFFFFFu;

/// True if a face reaches beyond its page, which then repeats: repeated() of bilinear.h.
bool reaches_beyond_page(const TexturedModel& model, std::size_t face);

/// Throws std::invalid_argument unless every face has a page below `page_count` and texture coordinates that exist, or
/// kNoPage; both writers call it first. O(faces).
void check_model(const TexturedModel& model, std::size_t page_count);

/// Pages that an OBJ or GLB refers to.
struct PageFile {
  std::filesystem::path file;  ///< complete image file on disk
  ImageFormat format = ImageFormat::png;
  /// Of a WebP page in a glTF: the same as PNG or JPEG, of any size, for readers that do not know EXT_texture_webp; empty:
  /// none, and readers have to know it.
  std::filesystem::path fallback{};
  ImageFormat fallback_format = ImageFormat::jpg;
  std::string material{};  ///< what its material is called; empty: by the page's number or file
};

enum class UpAxis { pos_x, neg_x, pos_y, neg_y, pos_z, neg_z };
inline constexpr Named<UpAxis> kUpAxisNames[] = {{"+x", UpAxis::pos_x}, {"-x", UpAxis::neg_x}, {"+y", UpAxis::pos_y},
                                                 {"-y", UpAxis::neg_y}, {"+z", UpAxis::pos_z}, {"-z", UpAxis::neg_z}};

/// The rotation, as the quaternion x, y, z, w, that takes a world axis to glTF's up, +y.
std::array<double, 4> gltf_rotation(UpAxis up);

/// exact: numbers read back as they are, faces in the input's order, materials page_0, page_1. texrecon: as mvs-texturing's texrecon
/// writes an OBJ, by whose rules other programs read it (OpenDroneMap's odm_orthophoto, its packing of materials and its glTF, and
/// Obj2Tiles): six decimals, all texture coordinates before the first material, faces page by page, materials material0000.
enum class ObjStyle { exact, texrecon };

/// How a glTF stores its geometry. plain: floats that every reader knows. compressed: the same values by
/// EXT_meshopt_compression, in the same order, a triangle possibly from another of its corners on. quantized: compressed,
/// and before that triangles are ordered so that they share vertices, positions rounded to a grid (16 bits; they stay
/// floats where its step would exceed an eighth of nearly all edges), texture coordinates to 1/65535 of a page, which is an
/// eighth of a texel on a page of 8192 (16 bits; floats where one lies beyond its page), normals to 1/127
/// (KHR_mesh_quantization). Readers have to know these extensions; CesiumJS, Babylon.js and, with its decoder, three.js do.
enum class GltfCoding { plain, compressed, quantized };

struct ModelOptions {
  WorldPoint offset;          ///< subtracted from every position (in double) before printing or rounding to float
  UpAxis up = UpAxis::pos_y;  ///< world axis that points up; becomes the root node's rotation in glTF (+y up)
  std::string srs{};          ///< Scene::srs and Scene::offset: for the root node's extras
  WorldPoint srs_offset{};
  bool normals = false;        ///< with smooth vertex normals, weighted by the faces' angles
  bool lit = false;            ///< of glTF: viewers light the model; else KHR_materials_unlit
  bool pageless_faces = true;  ///< in an OBJ; a glTF never has them
  ObjStyle obj_style = ObjStyle::exact;
  /// Largest size of a .bin beside a .gltf (exceeded only if one page's triangles take more): lengths that 31 bits
  /// hold.
  std::size_t buffer_limit_bytes = 0x7FFFFFFF;
  std::string copyright{};  ///< in a glTF, which viewers show; empty: none
  GltfCoding coding = GltfCoding::plain;
};

/// `NAME.obj` with NAME.mtl beside it: positions in the input's order, faces in the input's order (but see ObjStyle), usemtl where
/// the page changes; coordinates less the offset are printed so that they read back exactly. v runs upwards in OBJ. Faces
/// without a page are listed without texture coordinates, under a grey material, or left out. Throws OutputError.
void write_obj(const std::filesystem::path& obj_file, const TexturedModel& model, std::span<const PageFile> pages,
               const ModelOptions& options);

/// The photos that faces show, for readers of a glTF who pick a face.
struct PhotoTable {
  std::vector<std::uint32_t> of_face{};  ///< per face of the model, a row
  std::vector<std::string> name{};       ///< per row; empty: no photo
  std::vector<float> gsd{};              ///< per row, what a pixel covers on its faces; 0: not known
};

/// One self-contained binary file, or a description with buffers and pages beside it.
enum class GltfContainer { glb, files };
inline constexpr Named<GltfContainer> kGltfContainerNames[] = {{"glb", GltfContainer::glb},
                                                               {"files", GltfContainer::files}};

struct GltfFiles {
  std::filesystem::path file;                  ///< STEM.glb or STEM.gltf
  std::vector<std::filesystem::path> buffers;  ///< STEM.bin, STEM_1.bin, ...; none beside a GLB
  std::vector<FaceId> faces;                   ///< input face of every triangle, in the file's order
  std::size_t glb_bytes = 0;                   ///< of the GLB written, or of the one that was too large
};

/// glTF 2.0: KHR_materials_unlit or lit, one primitive a page, 32-bit indices, offset in the root node's extras. Faces
/// without a page are left out. A GLB ends at 4 GiB: what would be larger becomes files. With files, the pages stay where
/// they are and are referred to relative to STEM. WebP pages are for readers of EXT_texture_webp. Throws OutputError, also
/// when no face has a page or a local coordinate exceeds 32-bit floats. \param photos each face gets its row by
/// EXT_mesh_features and EXT_structural_metadata; null: none
GltfFiles write_gltf(const std::filesystem::path& stem, GltfContainer container, const TexturedModel& model,
                     std::span<const PageFile> pages, const ModelOptions& options, const PhotoTable* photos = nullptr);

/// Bytes of the buffers of such a glTF without pages and photos. Does most of the work of writing it.
std::size_t gltf_geometry_bytes(const TexturedModel& model, std::size_t pages, const ModelOptions& options);

/// A textured model from a file: ours or another program's.
struct LoadedModel {
  Mesh mesh;            ///< coordinates as they stand in the file, those of a glTF taken through its nodes
  TexturedModel model;  ///< model.mesh is null: set it to &mesh once this value no longer moves
  std::vector<Image> pages;
  std::vector<std::filesystem::path> page_files;  ///< per page; empty: the image is in the model's own file
  WorldPoint offset;  ///< to be added to positions: `offset.txt` beside an OBJ, a GLB root node's extras; else 0
};

/// What to add to the positions of an OBJ of ours: the first three numbers of `offset.txt` beside it; 0 where there is none.
/// Throws InputError.
WorldPoint read_offset(const std::filesystem::path& model);

/// Called with each page, by its number, in ascending order.
using TakePage = std::function<void(std::size_t number, Image page)>;

/// OBJ + MTL (map_Kd, of any writer), PLY with comments TextureFile (MeshLab, OpenMVS), GLB or glTF (triangles with a
/// baseColorTexture, of which EXT_texture_webp comes first; packed or quantized as GltfCoding has it or not; placed by the
/// nodes of the scene as by read_mesh(); of a model of ours, which the offset in its root's extras tells, the root's
/// rotation is not applied: it only says which way is up). Faces without a texture get kNoPage. Vertices without a place
/// are settled as by read_mesh(). `take_page`: takes each page as soon as it is read, and LoadedModel::pages stays empty.
/// Throws InputError.
LoadedModel read_textured_model(const std::filesystem::path& file, const TakePage& take_page = {});

}  // namespace gpvc::io
