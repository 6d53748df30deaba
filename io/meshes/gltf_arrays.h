// The arrays that a glTF's buffers consist of: what they hold, in which form, and their bytes.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/meshes/gltf_geometry.h"
#include "io/meshes/gltf_quantize.h"
#include "io/textured_model.h"

namespace gpvc::io {

/// The arrays of a primitive, in the order in which they lie in a buffer.
enum GltfArray { kIndices, kPositions, kTexcoords, kNormals, kPhotos };
inline constexpr std::array kAllArrays{kIndices, kPositions, kTexcoords, kNormals, kPhotos};
inline constexpr std::size_t kGltfArrays = kAllArrays.size();

/// How an array stores an element. https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#accessor-data-types
struct GltfForm {
  int component = 0;  ///< 5126: float
  const char* type = "";
  bool normalized = false;
  std::size_t bytes = 0;  ///< of an element with its padding
};

/// A model as the arrays of a glTF have it.
struct GltfData {
  GltfGeometry geometry;
  std::vector<std::array<float, 3>> normals;  ///< per position, or empty
  std::optional<PositionGrid> grid;           ///< that positions are stored on; nullopt: they are floats
  bool short_texcoords = false;               ///< texture coordinates have 16 bits
  /// Per primitive its arrays as EXT_meshopt_compression packs them; empty: they are not packed.
  std::vector<std::array<std::string, kGltfArrays>> packed;
};

/// The data to be written; all borrowed.
struct GltfAsset {
  const std::filesystem::path& file;
  const TexturedModel& model;
  std::span<const PageFile> pages;
  const ModelOptions& options;
  const GltfData& data;
  const PhotoTable* photos;  ///< null: none
};

/// Splits a model by its pages and codes it as options.coding asks. O(faces log faces). \param photos may be null
GltfData gltf_data(const TexturedModel& model, std::size_t pages, const ModelOptions& options,
                   const PhotoTable* photos);

constexpr std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

/// A position less the model's offset, in 32-bit floats.
std::array<float, 3> local_position(const WorldPoint& p, const WorldPoint& offset);

bool has_array(const GltfAsset& asset, GltfArray array);
GltfForm form_of(const GltfAsset& asset, GltfArray array);
std::size_t elements_of(const GltfPrimitive& primitive, GltfArray array);
/// In the buffer, as they are packed; 0 for an array that is not there.
std::size_t bytes_of(const GltfAsset& asset, std::size_t primitive, GltfArray array);
/// True if an array has a form that KHR_mesh_quantization allows.
bool is_quantized(const GltfData& data, const ModelOptions& options);

/// Gives the bytes of an array to `write`, block by block: bytes_of() of them.
void write_array(const GltfAsset& asset, std::size_t primitive, GltfArray array,
                 const std::function<void(const void* bytes, std::size_t count)>& write);

}  // namespace gpvc::io
