// What a TIFF's compressed strips and tiles say of damage: deflate by its checksums, JPEG by libjpeg's warnings, which OpenImageIO
// passes over. TIFF 6.0; Adobe Photoshop TIFF Technical Notes (deflate); TIFF Technical Note 2 (JPEG); BigTIFF.
//
// libtiff inflates no more of a strip than its rows need, and so seldom comes to the checksum behind them; what OpenImageIO
// inflates by itself it returns though zlib has refused it.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/images/codec.h"
#include "io/images/image_bounds.h"

namespace gpvc::io {
namespace {

/// The tags of a TIFF's first picture, as far as they are there.
class Directory {
 public:
  explicit Directory(const ImageBytes& image)
      : bytes_(image.view), big_endian_(bytes_.starts_with("MM")), wide_(number(2, 2) == kBigTiff) {
    if (!bytes_.starts_with("II") && !big_endian_) return;
    const std::uint64_t at = wide_ ? number(8, 8) : number(4, 4);
    begin_ = at + (wide_ ? 8 : 2);
    count_ = number(at, wide_ ? 8 : 2);
  }

  /// The numbers of a tag; empty where it is not there, or reaches beyond the file.
  std::vector<std::uint64_t> numbers(std::uint64_t tag) const {
    const std::uint64_t entry_bytes = wide_ ? 20 : 12, room = wide_ ? 8 : 4;
    for (std::uint64_t n = 0; n < count_; ++n) {
      const std::uint64_t entry = begin_ + n * entry_bytes;
      if (entry > bytes_.size()) break;
      if (number(entry, 2) != tag) continue;
      const std::uint64_t type = number(entry + 2, 2);
      const std::uint64_t each = type == kBytes ? 1 : type == kShort ? 2 : type == kLong ? 4 : type == kLong8 ? 8 : 0;
      const std::uint64_t count = number(entry + 4, room);
      if (each == 0 || count > bytes_.size() / each) return {};
      const std::uint64_t place = entry + 4 + room, from = count * each <= room ? place : number(place, room);
      std::vector<std::uint64_t> values;
      for (std::uint64_t i = 0; i < count; ++i) values.push_back(number(from + i * each, each));
      return values;
    }
    return {};
  }

 private:
  static constexpr std::uint64_t kBigTiff = 43, kShort = 3, kLong = 4, kBytes = 7, kLong8 = 16;

  /// 0 beyond the file.
  std::uint64_t number(std::uint64_t at, std::uint64_t count) const {
    if (at > bytes_.size() || count > bytes_.size() - at) return 0;
    std::uint64_t value = 0;
    for (std::uint64_t i = 0; i < count; ++i)
      value = value << 8 | static_cast<unsigned char>(bytes_[at + (big_endian_ ? i : count - 1 - i)]);
    return value;
  }

  std::string_view bytes_;
  bool big_endian_, wide_;
  std::uint64_t begin_ = 0, count_ = 0;
};

/// Throws InputError unless a strip, which leaves the tables of all strips to `tables`, can be decoded.
void check_jpeg_strip(const ImageBytes& tiff, std::string_view tables, std::string_view strip, std::uint64_t at) {
  constexpr std::size_t kMarker = 2;  // bytes of the tables' last marker, end of image, and of the strip's first
  if (strip.size() < kMarker) return;
  std::string whole(tables.empty() ? strip.substr(0, kMarker) : tables.substr(0, tables.size() - kMarker));
  whole += strip.substr(kMarker);
  const ImageBytes image{tiff.file, "the JPEG that begins at byte " + std::to_string(at), whole};
  if (!image.is_jpeg()) return;
  const ImageHeader header = read_jpeg_header(image);
  check_size(image.file, image.part, header.width, header.height, header.channels);
  check_jpeg(image);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height) *
                                   static_cast<std::size_t>(header.channels));
  decode_jpeg(image, header, pixels.data());
}

}  // namespace

std::string deflate_damage(std::string_view deflated) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(deflated.data()));
  stream.avail_in = static_cast<uInt>(deflated.size());
  std::array<Bytef, 1 << 15> inflated;
  int result = Z_OK;
  while (result == Z_OK) {
    stream.next_out = inflated.data();
    stream.avail_out = static_cast<uInt>(inflated.size());
    result = inflate(&stream, Z_NO_FLUSH);
  }
  std::string said = result == Z_STREAM_END  ? ""
                     : result == Z_BUF_ERROR ? "no end of the stream"
                     : stream.msg != nullptr ? stream.msg
                                             : "invalid data";
  inflateEnd(&stream);
  return said;
}

void refuse_damage(const std::filesystem::path& file, std::uint64_t at, const std::string& damage) {
  throw InputError(file, "byte " + std::to_string(at),
                   "cannot be decoded whole: the compressed data that begin here are damaged (" + damage + ")");
}

void check_tiff(const ImageBytes& image) {
  constexpr std::uint64_t kCompression = 259, kStrips = 273, kStripBytes = 279, kTiles = 324, kTileBytes = 325;
  constexpr std::uint64_t kFillOrder = 266, kTables = 347, kJpeg = 7, kAdobeDeflate = 8, kDeflate = 32946;
  const Directory directory(image);
  const std::vector<std::uint64_t> compression = directory.numbers(kCompression), order = directory.numbers(kFillOrder);
  const bool jpeg = !compression.empty() && compression[0] == kJpeg;
  if (compression.empty() || (!jpeg && compression[0] != kAdobeDeflate && compression[0] != kDeflate)) return;
  if (!order.empty() && order[0] != 1) return;  // bits the other way round
  const std::vector<std::uint64_t> table_bytes = directory.numbers(kTables);
  const std::string tables(table_bytes.begin(), table_bytes.end());
  std::uint64_t left = image.view.size();  // no bytes are of two strips, in no file but a crafted one
  for (const auto& [places, sizes] : {std::pair{kStrips, kStripBytes}, {kTiles, kTileBytes}}) {
    const std::vector<std::uint64_t> at = directory.numbers(places), bytes = directory.numbers(sizes);
    for (std::size_t i = 0; i < std::min(at.size(), bytes.size()); ++i) {
      if (at[i] > image.view.size() || bytes[i] > image.view.size() - at[i]) continue;  // libtiff finds it missing
      if (bytes[i] > left) return;
      left -= bytes[i];
      const std::string_view strip = image.view.substr(at[i], bytes[i]);
      if (jpeg)
        check_jpeg_strip(image, tables, strip, at[i]);
      else if (const std::string said = deflate_damage(strip); !said.empty())
        refuse_damage(image.file, at[i], said);
    }
  }
}

}  // namespace gpvc::io
