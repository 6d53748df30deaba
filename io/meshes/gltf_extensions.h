// Names of extensions of glTF that files are both written and read with.
#pragma once

namespace gpvc::io {

inline constexpr const char* kMeshoptCompression = "EXT_meshopt_compression";
inline constexpr const char* kMeshQuantization = "KHR_mesh_quantization";
inline constexpr const char* kTextureWebp = "EXT_texture_webp";

}  // namespace gpvc::io
