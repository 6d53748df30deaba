#include <zip.h>

#include <cstdint>
#include <list>
#include <vector>

#include "io/files/frees.h"
#include "io/files/npy_header.h"
#include "io/npz.h"
#include "io/output_file.h"

namespace gpvc::io {

struct NpzWriter::State {
  /// What libzip reads while it packs: borrowed.
  struct Member {
    std::string header;
    std::vector<zip_buffer_fragment_t> parts;
  };
  std::filesystem::path file;
  std::unique_ptr<zip_source_t, Frees<zip_source_free>> bytes;  ///< the archive, in memory until it is complete
  std::unique_ptr<zip_t, Frees<zip_discard>> archive;
  std::list<Member> members{};

  [[noreturn]] void fail(zip_error_t* error) const {
    throw OutputError(file, std::string("cannot be packed: ") + zip_error_strerror(error));
  }
};

NpzWriter::NpzWriter(std::filesystem::path file) : state_(new State{std::move(file), nullptr, nullptr}) {
  zip_error_t error{};
  state_->bytes.reset(zip_source_buffer_create(nullptr, 0, 0, &error));
  if (!state_->bytes) state_->fail(&error);
  zip_source_keep(state_->bytes.get());  // the archive takes one of both references
  state_->archive.reset(zip_open_from_source(state_->bytes.get(), ZIP_CREATE | ZIP_TRUNCATE, &error));
  if (!state_->archive) {
    zip_source_free(state_->bytes.get());
    state_->fail(&error);
  }
}

NpzWriter::~NpzWriter() = default;

template <typename T>
void NpzWriter::add(const std::string& name, std::span<const T> values, std::span<const std::size_t> shape) {
  State::Member& member = state_->members.emplace_back();
  member.header = npy_header(npy_dtype<T>(), shape);
  const auto fragment = [](const void* data, std::size_t bytes) {
    return zip_buffer_fragment_t{static_cast<zip_uint8_t*>(const_cast<void*>(data)), bytes};
  };
  member.parts = {fragment(member.header.data(), member.header.size()), fragment(values.data(), values.size_bytes())};
  zip_t* archive = state_->archive.get();
  zip_source_t* source = zip_source_buffer_fragment(archive, member.parts.data(), member.parts.size(), 0);
  if (source == nullptr) state_->fail(zip_get_error(archive));
  const zip_int64_t number = zip_file_add(archive, (name + ".npy").c_str(), source, ZIP_FL_ENC_UTF_8);
  if (number < 0) {
    zip_source_free(source);
    state_->fail(zip_get_error(archive));
  }
  // The same bytes whenever they are written: MS-DOS's first day.
  const auto entry = static_cast<zip_uint64_t>(number);
  zip_file_set_dostime(archive, entry, 0, (1 << 5) | 1, 0);
  zip_set_file_compression(archive, entry, ZIP_CM_DEFLATE, 6);
}

void NpzWriter::commit() {
  if (zip_close(state_->archive.get()) != 0) state_->fail(zip_get_error(state_->archive.get()));
  static_cast<void>(state_->archive.release());
  zip_source_t* bytes = state_->bytes.get();
  if (zip_source_open(bytes) != 0) state_->fail(zip_source_error(bytes));
  OutputFile out(state_->file);
  std::vector<char> part(std::size_t{1} << 20);
  for (zip_int64_t count; (count = zip_source_read(bytes, part.data(), part.size())) > 0;)
    out.write(part.data(), static_cast<std::size_t>(count));
  zip_source_close(bytes);
  out.commit();
}

template void NpzWriter::add(const std::string&, std::span<const std::uint8_t>, std::span<const std::size_t>);
template void NpzWriter::add(const std::string&, std::span<const std::int32_t>, std::span<const std::size_t>);
template void NpzWriter::add(const std::string&, std::span<const std::uint32_t>, std::span<const std::size_t>);
template void NpzWriter::add(const std::string&, std::span<const std::uint64_t>, std::span<const std::size_t>);
template void NpzWriter::add(const std::string&, std::span<const float>, std::span<const std::size_t>);

}  // namespace gpvc::io
