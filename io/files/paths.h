// Paths as text, and more of what lies there than io/paths.h tells. Not installed, so that fs is a name in this folder's
// sources alone.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "io/paths.h"

namespace gpvc::io {

namespace fs = std::filesystem;

/// True for a folder, behind links too; false where there is none or it cannot be looked at.
inline bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// True for "._NAME", which macOS leaves beside NAME on disks of other systems: what it knows of NAME, no file of the kind.
inline bool is_apple_double(const fs::path& file) { return file.filename().string().starts_with("._"); }

/// The folder of a file, "." for a bare name.
inline fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : "."; }

/// The first `count` bytes of a file; fewer if it is shorter, none if it cannot be read.
inline std::string first_bytes(const fs::path& file, std::size_t count) {
  if (!is_file(file)) return {};
  std::string bytes(count, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

/// Turns '\' into '/' and drops "file:///": for paths written on Windows.
inline std::string with_slashes(std::string_view path) {
  constexpr std::string_view kScheme = "file:///";
  std::string text(path.starts_with(kScheme) ? path.substr(kScheme.size()) : path);
  std::replace(text.begin(), text.end(), '\\', '/');
  return text;
}

}  // namespace gpvc::io
