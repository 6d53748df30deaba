// A file without a name, for what does not fit in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

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
  /// The first bytes of the file in the place where they are read, which the system fetches and drops as it needs memory. To be called
  /// once, when they are written.
  std::span<const std::uint8_t> map(std::size_t bytes);

 private:
  std::filesystem::path folder_;
  void* mapping_ = nullptr;
  std::size_t mapped_bytes_ = 0;
  int descriptor_ = -1;
};

}  // namespace gpvc::io
