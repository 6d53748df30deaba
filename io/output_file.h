// A file that appears under its name only when it is complete.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "error.h"

namespace gpvc::io {

/// Writes to `final_name` + a temporary suffix in the same folder; commit() flushes, checks and renames.
/// Without commit() the temporary file is removed. write() and commit() throw OutputError (disk full, no permission).
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path final_name);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  void write(const void* data, std::size_t bytes);
  void write(const std::string& text) { write(text.data(), text.size()); }
  /// Of the file under its temporary name, for a library that writes and reads it by itself. \pre not after write()
  int descriptor() const;
  /// to_disk: the file survives a power cut. to_system: it survives the end of the process, and is there sooner.
  enum class Flush { to_disk, to_system };
  void commit(Flush flush = Flush::to_disk);

 private:
  std::filesystem::path final_name_, temporary_;
  std::FILE* file_ = nullptr;
};

/// Writes a file of these bytes as an OutputFile does.
void write_file(const std::filesystem::path& file, std::string_view bytes);

/// Copies a file under another name, as an OutputFile does. Throws InputError where it cannot be read.
void copy_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Removes what killed processes have left of files whose names begin with `name`. No process may be writing them.
void remove_unfinished(const std::filesystem::path& folder, const std::string& name);

}  // namespace gpvc::io
