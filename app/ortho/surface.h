// A textured mesh as orthophotos show it, from a result or from photos.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/ortho/page_store.h"
#include "app/pipeline/run.h"
#include "io/textured_model.h"
#include "visibility/device.h"

namespace gpvc::ortho {

/// textured: is shown; bare: no photo shows it, and it hides what is below; absent: most photos show background in its place, so that
/// it is left out.
enum class FaceKind : std::uint8_t { textured, bare, absent };

inline constexpr std::uint32_t kNoPhoto = 0xFFFFFFFFU;

struct Surface {
  Mesh mesh;
  io::TexturedModel model;           ///< model.mesh is null
  std::vector<FaceKind> kind;        ///< per face
  std::vector<std::uint32_t> photo;  ///< per face, its number or kNoPhoto; empty: unknown
  std::vector<std::string> photos;   ///< names by number
  io::ModelOptions coordinates;      ///< offset, srs and srs_offset: what the positions are
  std::optional<WorldPoint> up;      ///< away from what the cameras look at; nullopt: unknown
  std::filesystem::path source;      ///< of the mesh, for errors
};

/// The models of a result: a file, or those of a folder that gpvc has written (model.obj or model.glb, or the tiles obj/N/model.obj of
/// a job). Throws InputError where there is none.
std::vector<std::filesystem::path> models_of(const std::filesystem::path& from);

/// Reads a result's models with the reference system that offset.txt or a metadata.xml states, and its photos by number where labels.npy
/// and tags.npy tell them. \param unseen what becomes of faces that
/// no photo shows. Throws InputError.
Surface read_surface(const std::vector<std::filesystem::path>& models, atlas::UnseenFaces unseen, PageStore& pages);

struct TexturedSurface {
  Surface surface;
  std::optional<visibility::DeviceInfo> device;  ///< that drew the views; empty: they were drawn natively
};
/// Textures a mesh, by all steps of pipeline::texture_into(), and keeps work in the folder as that does. Throws what that throws.
TexturedSurface texture_surface(const pipeline::Run& run, PageStore& pages, pipeline::OutputFolder& folder);

}  // namespace gpvc::ortho
