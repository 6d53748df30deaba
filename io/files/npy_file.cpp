// NumPy's .npy format, version 1.0: "\x93NUMPY", 1, 0, uint16 header length, a Python dict padded with blanks to a
// multiple of 64 bytes and closed by a line end, then the values.
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
#include <cassert>
#include <limits>

#include "io/file_bytes.h"
#include "io/files/npy_header.h"
#include "io/files/text_scan.h"
#include "io/npy.h"
#include "io/output_file.h"

namespace gpvc::io {

namespace {

/// The text after `'key':` in the header's dict.
std::string_view value_of(const std::filesystem::path& file, std::string_view dict, std::string_view key) {
  const std::size_t at = dict.find("'" + std::string(key) + "'");
  const std::size_t colon = at == std::string_view::npos ? at : dict.find(':', at);
  if (colon == std::string_view::npos) throw InputError(file, "byte 10", "the array's header has no " + quote(key));
  dict.remove_prefix(colon + 1);
  while (!dict.empty() && is_blank(dict.front())) dict.remove_prefix(1);
  return dict;
}

std::vector<std::size_t> shape_from(const std::filesystem::path& file, std::string_view dict) {
  std::string_view tuple = value_of(file, dict, "shape");
  const std::size_t close = tuple.find(')');
  if (!tuple.starts_with('(') || close == std::string_view::npos)
    throw InputError(file, "byte 10", "the array's shape is not a tuple");
  tuple = tuple.substr(1, close - 1);
  std::vector<std::size_t> shape;
  while (!tuple.empty()) {
    const std::size_t comma = tuple.find(',');
    std::string_view item = tuple.substr(0, comma);
    tuple.remove_prefix(comma == std::string_view::npos ? tuple.size() : comma + 1);
    const std::string_view word = next_word(item);
    if (word.empty() && tuple.empty()) break;
    const std::optional<std::size_t> extent = integer_from<std::size_t>(word);
    if (!extent) throw InputError(file, "byte 10", "the array's shape holds " + quote(word));
    shape.push_back(*extent);
  }
  return shape;
}

}  // namespace

template <typename T>
void write_npy(const std::filesystem::path& file, std::span<const T> values, std::span<const std::size_t> shape) {
  [[maybe_unused]] std::size_t product = 1;
  for (const std::size_t extent : shape) product *= extent;
  assert(product == values.size());
  OutputFile out(file);
  out.write(npy_header(npy_dtype<T>(), shape));
  out.write(values.data(), values.size_bytes());
  out.commit();
}

template <typename T>
NpyArray<T> read_npy(const std::filesystem::path& file) {
  const FileBytes bytes(file);
  ByteReader reader(file, bytes.view());
  constexpr const char* kHeader = "the array's header";
  if (reader.take(6, kHeader) != "\x93NUMPY") throw InputError(file, "byte 0", "is not a NumPy array (.npy)");
  const std::string_view version = reader.take(2, kHeader);
  const std::uint32_t length =
      version[0] == 1 ? reader.read<std::uint16_t>(kHeader) : reader.read<std::uint32_t>(kHeader);
  const std::string_view dict = reader.take(length, kHeader);
  const std::string expected = "'" + std::string(npy_dtype<T>()) + "'";
  const std::string_view found = value_of(file, dict, "descr");
  if (!found.starts_with(expected))
    throw InputError(file, "byte 10",
                     "expected values of type " + expected + ", found " + quote(found.substr(0, found.find(','))));
  if (!value_of(file, dict, "fortran_order").starts_with("False"))
    throw InputError(file, "byte 10", "expected C order, found Fortran order");
  NpyArray<T> array;
  array.shape = shape_from(file, dict);
  std::size_t count = 1;
  for (const std::size_t extent : array.shape) {
    if (extent != 0 && count > reader.remaining() / extent) reader.fail("the file ends inside the values");
    count *= extent;
  }
  const std::string_view raw = reader.take(std::uint64_t{count} * sizeof(T), "the values");
  array.values.resize(count);
  if (count > 0) std::memcpy(array.values.data(), raw.data(), raw.size());
  return array;
}

template NpyArray<std::uint8_t> read_npy(const std::filesystem::path&);
template NpyArray<std::int32_t> read_npy(const std::filesystem::path&);
template NpyArray<std::uint32_t> read_npy(const std::filesystem::path&);
template NpyArray<float> read_npy(const std::filesystem::path&);
template NpyArray<double> read_npy(const std::filesystem::path&);

template void write_npy(const std::filesystem::path&, std::span<const std::uint8_t>, std::span<const std::size_t>);
template void write_npy(const std::filesystem::path&, std::span<const std::int32_t>, std::span<const std::size_t>);
template void write_npy(const std::filesystem::path&, std::span<const std::uint32_t>, std::span<const std::size_t>);
template void write_npy(const std::filesystem::path&, std::span<const float>, std::span<const std::size_t>);
template void write_npy(const std::filesystem::path&, std::span<const double>, std::span<const std::size_t>);

}  // namespace gpvc::io
