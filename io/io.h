// Reading scenes, meshes and photos; writing NumPy arrays, page images, OBJ and glTF. Every reader throws InputError
// (file, place, expectation); every writer throws OutputError and leaves either the complete file or nothing under the
// final name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/error.h"
#include "io/image.h"
#include "io/photos.h"
#include "io/progress.h"
#include "io/scene.h"

namespace gpvc::io {

// --- in

/// PLY (ascii, binary little and big endian, float or double, any extra properties) or OBJ, by content, not by
/// extension. Polygons of more than three vertices are split, as a fan where that turns no triangle over, else by
/// cutting off ears; Mesh::source_face leads back to them. OBJ's groups, texture coordinates and normals are passed
/// over, as are its lines and points. Throws InputError on NaN or infinite coordinates, on indices out of range, on a
/// truncated file, and on a mesh without faces. O(file size).
Mesh read_mesh(const std::filesystem::path& file);

/// Puts `more` behind `all`: its vertices and faces count on, and so do the polygons that Mesh::source_face leads to,
/// as if one file held both meshes. \pre together at most 2^32 - 2 vertices, faces and polygons. O(more), and O(all)
/// where the first polygons come.
void append_mesh(Mesh& all, const Mesh& more);

/// How a mesh hangs together, as far as a halfedge structure can hold it.
struct MeshTopology {
  std::size_t components = 0;  ///< connected over edges, of the faces held
  std::size_t boundary_edges = 0, boundary_loops = 0;
  std::size_t nonmanifold_faces = 0;  ///< not held: on an edge that has two faces already, or turned against them
  std::size_t degenerate_faces = 0;   ///< not held: name a vertex twice
  std::size_t unused_vertices = 0;    ///< in no face held
};

/// What is odd about a mesh's elements; all of them are kept in their place.
struct MeshFlaws {
  std::size_t degenerate_faces = 0;       ///< name a vertex twice
  std::size_t flat_faces = 0;             ///< three vertices in a line, or two at one place
  std::size_t duplicate_faces = 0;        ///< name the same vertices as an earlier face, in any order
  std::size_t unreferenced_vertices = 0;  ///< in no face
  std::size_t duplicate_vertices = 0;     ///< at the place of an earlier vertex
};

/// O(n log n).
MeshFlaws mesh_flaws(const Mesh& mesh);

/// Through OpenMesh. Only a report: the arrays of Mesh stay the truth. O(faces).
MeshTopology mesh_topology(const Mesh& mesh);

struct SceneOptions {
  /// Where the photos lie, at any depth and behind links to folders, too; matched by the longest common tail of their
  /// paths. Default: where the scene's file says, then the format's usual folders.
  std::optional<std::filesystem::path> images_dir{};
  /// Views whose photo is not found keep an empty View::photo (and, in formats that leave the size to the photo, a
  /// camera of width 0) instead of being an error.
  bool allow_missing_photos = false;
  /// Which of the views, in their final order and under their final names, need their photo; default: all. A photo of
  /// another view that is missing, ambiguous, unreadable or of another shape than its camera leaves View::photo empty
  /// (and a camera of width 0, see above) instead of being an error.
  std::function<std::vector<bool>(std::span<const View> views)> needed{};
  /// Photos are reduced by this factor (box average) and cameras with them; >= 1.
  int downscale = 1;
  /// Where masks lie, by the views' names; default: beside the photos.
  std::optional<std::filesystem::path> masks_dir{};
  bool masks = true;  ///< look for masks, and use alpha channels
};

/// A scene of any format that a NAME_scene.cpp of this folder reads, told by what `source` (a file or a folder) is or
/// plainly holds; each of those files states its format's pixel and axis conventions, which are converted to ours.
/// Checks that every photo exists and that its header has the camera's size, without decoding it: a photo of another
/// size but the same shape scales its camera; the error names missing photos up to a handful. A reduced camera is width
/// / N, height / N (cut), fx / N, fy / N, cx / N, cy / N, which is exact in this convention. What was left out or
/// assumed is in Scene::warnings. Throws InputError.
Scene read_scene(const std::filesystem::path& source, const SceneOptions& options);

/// Decodes a photo to 3 channels of 8 bits: grey is repeated, alpha dropped, deeper samples scaled with rounding;
/// linear light (EXR, HDR) gets sRGB's curve, with 1 as white. EXIF orientation is not applied, to raw photos (DNG)
/// neither (cameras are calibrated on the stored pixels). Errors are a truncated file, a JPEG with zeros in the place
/// of data (where its tables tell), and a claim of more pixels than the file can hold, or than 2^30. Raw photos need an
/// OpenImageIO with LibRaw.
Image read_image(const std::filesystem::path& file);

/// An ICC profile, byte for byte as image files embed it; empty: none.
using ColorProfile = std::vector<std::uint8_t>;

/// From the header alone. Empty also for what is no profile of RGB colours (grey and CMYK photos come converted).
/// Throws InputError.
ColorProfile read_color_profile(const std::filesystem::path& file);

template <typename T>
struct NpyArray {
  std::vector<std::size_t> shape;
  std::vector<T> values;
};

/// A NumPy .npy of exactly this type, little endian, C order; for T = uint8_t, int32_t, uint32_t, float, double. Throws
/// InputError on another type or order and on a truncated file.
template <typename T>
NpyArray<T> read_npy(const std::filesystem::path& file);

// --- out

/// Writes to `final_name` + a temporary suffix in the same folder; commit() flushes to disk, checks and renames.
/// Without commit() the temporary file is removed. write() and commit() throw OutputError (disk full, no permission).
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path final_name);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  void write(const void* data, std::size_t bytes);
  void write(const std::string& text) { write(text.data(), text.size()); }
  void commit();

 private:
  std::filesystem::path final_name_, temporary_;
  std::FILE* file_ = nullptr;
};

/// NumPy .npy, version 1.0, little endian, C order. The product of `shape` must equal values.size().
void write_npy(const std::filesystem::path& file, std::span<const std::uint8_t> values,
               std::span<const std::size_t> shape);
void write_npy(const std::filesystem::path& file, std::span<const std::int32_t> values,
               std::span<const std::size_t> shape);
void write_npy(const std::filesystem::path& file, std::span<const std::uint32_t> values,
               std::span<const std::size_t> shape);
void write_npy(const std::filesystem::path& file, std::span<const float> values, std::span<const std::size_t> shape);
void write_npy(const std::filesystem::path& file, std::span<const double> values, std::span<const std::size_t> shape);

enum class ImageFormat { png, jpg };

/// `quality` 1..100 applies to jpg (chroma is not subsampled). `profile` is embedded; without one, PNG says sRGB and
/// JPEG nothing, which means the same.
void write_image(const std::filesystem::path& file, const Image& image, ImageFormat format, int quality,
                 const ColorProfile& profile = {});

/// Texture coordinates in page units: (0,0) top-left corner of the page, (1,1) bottom-right; glTF's convention.
struct TexCoord {
  float u = 0, v = 0;
};

/// A textured mesh in the input's face order. Borrowed, except what the atlas made.
struct TexturedModel {
  const Mesh* mesh = nullptr;
  std::vector<TexCoord> texcoords;
  std::vector<Triangle> face_texcoords;  ///< per face, indices into texcoords
  std::vector<std::uint32_t> face_page;  ///< per face, index into page files, or kNoPage
};

/// face_page of a face without texture, whose face_texcoords mean nothing.
inline constexpr std::uint32_t kNoPage = 0xFFFFFFFFu;

/// Throws std::invalid_argument unless every face has a page below `page_count` and texture coordinates that exist, or
/// kNoPage; both writers ask it first. O(faces).
void check_model(const TexturedModel& model, std::size_t page_count);

/// Pages that an OBJ or GLB refers to.
struct PageFile {
  std::filesystem::path file;  ///< complete image file on disk
  ImageFormat format = ImageFormat::png;
};

enum class UpAxis { pos_x, neg_x, pos_y, neg_y, pos_z, neg_z };

struct ModelOptions {
  WorldPoint offset;          ///< subtracted from every position (in double) before printing or rounding to float
  UpAxis up = UpAxis::pos_y;  ///< world axis that points up; becomes the root node's rotation in glTF (+y up)
  std::string srs{};          ///< Scene::srs and Scene::offset: for the root node's extras
  WorldPoint srs_offset{};
  bool normals = false;  ///< with smooth vertex normals, weighted by the faces' angles
  /// Of a .bin beside a .gltf, unless a single page's triangles are more: lengths that 31 bits hold.
  std::size_t buffer_limit_bytes = 0x7FFFFFFF;
};

/// `NAME.obj` with NAME.mtl beside it: positions in the input's order, faces in the input's order, usemtl where the
/// page changes; coordinates less the offset are printed so that they read back exactly. v runs upwards in OBJ. Faces
/// without a page are listed without texture coordinates, under a grey material.
void write_obj(const std::filesystem::path& obj_file, const TexturedModel& model, std::span<const PageFile> pages,
               const ModelOptions& options);

/// One self-contained binary file, or a description with buffers and pages beside it.
enum class GltfContainer { glb, files };

struct GltfFiles {
  std::filesystem::path file;                  ///< STEM.glb or STEM.gltf
  std::vector<std::filesystem::path> buffers;  ///< STEM.bin, STEM_1.bin, ...; none beside a GLB
  std::vector<FaceId> faces;                   ///< input face of every triangle, in the file's order
  std::size_t glb_bytes = 0;                   ///< of the GLB written, or of the one that was too large
};

/// glTF 2.0: KHR_materials_unlit, one primitive a page, 32-bit indices, offset in the root node's extras. Faces without
/// a page are left out. A GLB ends at 4 GiB: what would be larger becomes files. With files, the pages stay where they
/// are and are referred to relative to STEM. Throws OutputError when no face has a page or a local coordinate exceeds
/// 32-bit floats.
GltfFiles write_gltf(const std::filesystem::path& stem, GltfContainer container, const TexturedModel& model,
                     std::span<const PageFile> pages, const ModelOptions& options);

/// A textured model from a file: ours or another program's.
struct LoadedModel {
  Mesh mesh;            ///< coordinates as they stand in the file
  TexturedModel model;  ///< model.mesh is null: set it to &mesh where the value has come to rest
  std::vector<Image> pages;
  WorldPoint offset;  ///< to be added to positions: `offset.txt` beside an OBJ, a GLB root node's extras; else 0
};

/// OBJ + MTL (map_Kd, any writer's), GLB or glTF (triangles with a baseColorTexture; rotations of nodes are not
/// applied: our writer's root rotation only says which way is up). Faces without a texture get kNoPage. Throws
/// InputError.
LoadedModel read_textured_model(const std::filesystem::path& file);

// --- scenes for other programs

/// colmap: sparse/{cameras,images,points3D}.txt; cam: mvs-texturing's NAME.cam beside each photo; mvs: OpenMVS'
/// scene.mvs.
enum class SceneTarget { colmap, cam, mvs };

/// The first thing of a lens that the format cannot state ("p1", "the equisolid (fisheye) projection"); nullopt when it
/// can state all of it.
std::optional<std::string> lost_term(SceneTarget target, const Camera& camera);

/// Whether a name ends like an image's: .jpg, .tif, .dng and others, in any case of letters. What else stands behind
/// its last dot belongs to the name.
bool has_image_extension(const std::filesystem::path& name);

/// Where the format looks for the photo of each used view, relative to its folder. Throws OutputError where two views
/// would meet in one file.
std::vector<std::filesystem::path> photo_places(SceneTarget target, const Scene& scene, std::span<const ViewId> used);

/// Where the format's programs look for the mask of a photo at one of `photo_places`, as their manuals have it:
/// COLMAP's ImageReader.mask_path has NAME.EXT.png (colmap.github.io/faq, "Mask image regions"), here in masks/;
/// OpenMVS takes NAME.mask.png beside the photo (with --ignore-mask-label 0). nullopt for cam: mvs-texturing knows no
/// masks, and would take one beside a PNG for its photo.
std::optional<std::filesystem::path> mask_place(SceneTarget target, const std::filesystem::path& photo_place);

/// Writes cameras and poses, and the names in `places`, below `folder`, whose sub-folder `sparse` exists for colmap; no
/// photo is touched. Numbers read back exactly, and so do positions in world and pixels to the rounding of t = -R C.
/// Throws OutputError, also for a lens with a lost_term.
void write_scene(SceneTarget target, const Scene& scene, std::span<const ViewId> used,
                 std::span<const std::filesystem::path> places, const std::filesystem::path& folder);

}  // namespace gpvc::io
