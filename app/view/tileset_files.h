// The files of a tileset that the page may load.
#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace gpvc::view {

/// True for a folder with a tileset.json.
bool is_tileset(const std::filesystem::path& folder);

/// Its tileset.json and what that names, by relative paths; what would leave the folder is left out. Throws InputError for what is no
/// tileset of 3D Tiles 1.1 with glTF contents.
std::set<std::string> tileset_files(const std::filesystem::path& folder);

}  // namespace gpvc::view
