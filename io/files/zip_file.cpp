#include "io/files/zip_file.h"

#include <algorithm>

#include "io/error.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"

namespace gpvc::io {

namespace {

std::string text_of(zip_error_t& error) {
  std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

}  // namespace

ZipFile::ZipFile(const std::filesystem::path& file, std::string_view bytes) : file_(file), size_(bytes.size()) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  if (source != nullptr) archive_.reset(zip_open_from_source(source, ZIP_RDONLY, &error));
  if (!archive_) {
    if (source != nullptr) zip_source_free(source);  // an archive that is open owns it
    throw InputError(file, "", "cannot be read as a zip archive, or ends too early: " + text_of(error));
  }
  zip_error_fini(&error);
  const auto count = static_cast<zip_uint64_t>(zip_get_num_entries(archive_.get(), 0));
  for (zip_uint64_t i = 0; i < count; ++i)
    // Windows' older packers separate folders by '\'.
    if (const char* const name = zip_get_name(archive_.get(), i, 0)) members_.emplace(with_slashes(name), i);
}

void ZipFile::fail(const std::string& member, const std::string& reason) const {
  throw InputError(file_, quote(member), reason);
}

std::string ZipFile::read(const std::string& member, std::size_t most) const {
  const auto found = members_.find(member);
  if (found == members_.end()) fail(member, "is not in the archive");
  const zip_uint64_t number = found->second;
  zip_stat_t stat;
  constexpr zip_uint64_t kNeeded = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE;
  if (zip_stat_index(archive_.get(), number, 0, &stat) != 0 || (stat.valid & kNeeded) != kNeeded)
    fail(member, "the archive does not state its size");
  // Both sizes are claims. Divided, since they may be any numbers.
  const zip_uint64_t packed = std::min<zip_uint64_t>(stat.comp_size, size_);
  if (stat.size > kAlwaysUnpacked && stat.size / kMostUnpacked > packed)
    fail(member, "claims to unpack to " + std::to_string(stat.size) + " bytes from " + std::to_string(packed) +
                     ", more than any list of cameras does");
  const std::unique_ptr<zip_file_t, Frees<zip_fclose>> opened(zip_fopen_index(archive_.get(), number, 0));
  if (!opened) fail(member, std::string("cannot be unpacked: ") + zip_strerror(archive_.get()));
  std::string text(static_cast<std::size_t>(std::min<zip_uint64_t>(stat.size, most)), '\0');
  const bool whole = text.size() == stat.size;
  // At the end of the member, libzip compares its checksum.
  char behind = 0;
  if (zip_fread(opened.get(), text.data(), text.size()) != static_cast<zip_int64_t>(text.size()) ||
      (whole && zip_fread(opened.get(), &behind, 1) != 0))
    fail(member, "is damaged or not of the size that the archive states");
  return text;
}

}  // namespace gpvc::io
