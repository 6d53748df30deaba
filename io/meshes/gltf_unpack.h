// Reads what EXT_meshopt_compression has packed.
// https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_meshopt_compression
#pragma once

#include <tiny_gltf.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace gpvc::io {

/// A file with packed arrays as tinygltf takes it, which wants bytes for every buffer: those that a file gives in packed form alone
/// become a byte, until unpack_views() is called. nullopt where there are none, or the file is no JSON. \param json of `file`
/// \param binary is a GLB
std::optional<std::string> with_placeholders(std::string_view file, std::string_view json, bool binary);

/// Gives each packed buffer view a buffer of its own with what it holds. Throws InputError where that is damaged, or more than
/// its bytes can hold. O(bytes).
void unpack_views(const std::filesystem::path& file, tinygltf::Model& model);

}  // namespace gpvc::io
