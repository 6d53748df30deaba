// Reads what EXT_meshopt_compression has packed.
// https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_meshopt_compression
#pragma once

#include <tiny_gltf.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace gpvc::io {

/// Makes a file with packed arrays readable for tinygltf, which refuses buffers without bytes: the fallback buffers of
/// EXT_meshopt_compression, which the file gives in packed form alone, get one byte each. Their arrays are valid after unpack_views().
/// Returns the changed file; nullopt where it has no such buffer or is no JSON. \param json of `file` \param binary is a GLB
std::optional<std::string> fill_fallback_buffers(std::string_view file, std::string_view json, bool binary);

/// Gives each packed buffer view a buffer of its own with what it holds. Throws InputError where that is damaged, or more than
/// its bytes can hold. O(bytes).
void unpack_views(const std::filesystem::path& file, tinygltf::Model& model);

}  // namespace gpvc::io
