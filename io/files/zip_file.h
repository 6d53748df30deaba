// Zip archives, through libzip.
#pragma once

#include <zip.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "io/files/frees.h"

namespace gpvc::io {

/// True if the bytes begin as those of a zip archive that holds anything do.
inline bool is_zip(std::string_view bytes) { return bytes.starts_with("PK\3\4"); }

/// The members of an archive. Only what is asked for is unpacked.
class ZipFile {
 public:
  /// Borrows both until the end; `file` is used in error messages only. Throws InputError where the directory at the
  /// archive's end is missing or broken, as after a download that was cut off.
  ZipFile(const std::filesystem::path& file, std::string_view bytes);
  using Members = std::map<std::string, zip_uint64_t, std::less<>>;
  /// Names, with their folders and '/'-separated, and numbers. Of several with the same name, the first.
  const Members& members() const { return members_; }
  bool has(std::string_view member) const { return members_.contains(member); }
  /// The whole member, or its first `most` bytes. Throws InputError where it is missing, encrypted, packed in a way that
  /// libzip does not know, damaged, or claims more than kMostUnpacked times the bytes that it is packed in, or those of the
  /// archive.
  std::string read(const std::string& member, std::size_t most = std::string::npos) const;

  /// Lists of cameras, which are text, are packed to a fifth or a twentieth; Deflate can pack to a thousandth, and such
  /// an archive would take a thousand times its size of memory. Up to a MiB anything goes.
  static constexpr std::size_t kMostUnpacked = 200, kAlwaysUnpacked = std::size_t{1} << 20;

 private:
  [[noreturn]] void fail(const std::string& member, const std::string& reason) const;
  const std::filesystem::path& file_;
  std::size_t size_;  ///< of the archive
  std::unique_ptr<zip_t, Frees<zip_discard>> archive_;
  Members members_;
};

}  // namespace gpvc::io
