// What lies at a path.
#pragma once

#include <filesystem>

#include "error.h"

namespace gpvc::io {

inline constexpr const char* kNotRegular = "is a pipe, socket or device, expected a regular file";

/// True for a regular file, behind links too; false where there is none or it cannot be looked at.
inline bool is_file(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

/// Throws InputError if something else than a regular file or a folder lies there: reading a pipe may wait for ever, and a
/// device may have no end.
inline void refuse_special_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::is_other(status)) throw InputError(path, "", kNotRegular);
}

}  // namespace gpvc::io
