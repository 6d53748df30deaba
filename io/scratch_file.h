// A file without a name, for what does not fit in memory.
#pragma once

#include <cstddef>
#include <filesystem>

#include "error.h"

namespace gpvc::io {

/// Lies in a folder, appears in no listing, and is gone with the process, however that ends. All functions throw
/// OutputError naming the folder (disk full, no permission). Several threads may use different places.
class ScratchFile {
 public:
  explicit ScratchFile(std::filesystem::path folder);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  /// \param place byte of the file
  void write(std::size_t place, const void* data, std::size_t bytes);
  /// Reads what was written at `place`.
  void read(std::size_t place, void* data, std::size_t bytes) const;

 private:
  std::filesystem::path folder_;
  int descriptor_ = -1;
};

}  // namespace gpvc::io
