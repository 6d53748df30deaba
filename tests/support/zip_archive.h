// Zip archives for tests.
#pragma once

#include <zip.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace gpvc::test {

/// The bytes of an archive of these members (name, contents), packed by Deflate.
inline std::string zipped(const std::vector<std::pair<std::string, std::string>>& members) {
  zip_source_t* const bytes = zip_source_buffer_create(nullptr, 0, 0, nullptr);
  zip_t* const archive = zip_open_from_source(bytes, ZIP_TRUNCATE, nullptr);
  if (archive == nullptr) throw std::logic_error("no archive");
  zip_source_keep(bytes);
  for (const auto& [name, contents] : members) {
    zip_source_t* const source = zip_source_buffer(archive, contents.data(), contents.size(), 0);
    const zip_int64_t number = zip_file_add(archive, name.c_str(), source, 0);
    if (number < 0) throw std::logic_error(zip_strerror(archive));
    zip_set_file_compression(archive, static_cast<zip_uint64_t>(number), ZIP_CM_DEFLATE, 9);
  }
  if (zip_close(archive) != 0) throw std::logic_error(zip_strerror(archive));
  std::string out;
  zip_source_open(bytes);
  zip_source_seek(bytes, 0, SEEK_END);
  out.resize(static_cast<std::size_t>(zip_source_tell(bytes)));
  zip_source_seek(bytes, 0, SEEK_SET);
  zip_source_read(bytes, out.data(), out.size());
  zip_source_close(bytes);
  zip_source_free(bytes);
  return out;
}

}  // namespace gpvc::test
