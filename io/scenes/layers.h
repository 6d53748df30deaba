// Files that belong to a photo by their names: masks, and RealityCapture's layers.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>

namespace gpvc::io {

/// The endings of masks and layers, most usual first.
std::span<const char* const> layer_endings();

/// The files of folders, each of which is listed once.
class FolderNames {
 public:
  /// The file at this path, or else one that differs from it in the case of its name's letters alone; empty: there is none.
  std::filesystem::path find(const std::filesystem::path& wanted);

  /// The layer that RealityCapture takes for a photo: .LAYER/NAME.EXT in the photo's folder, also with another or a further
  /// extension, or NAME.EXT.LAYER.EXT beside it. Empty: there is none.
  std::filesystem::path find_layer(const std::filesystem::path& photo, const std::string& layer);

 private:
  struct Names {
    std::map<std::string, std::filesystem::path> exact, folded;
  };
  const Names& names_in(const std::filesystem::path& folder);

  std::map<std::filesystem::path, Names> folders_;
};

}  // namespace gpvc::io
