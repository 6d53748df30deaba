// PNG pages and their samples, compressed in parallel. https://www.w3.org/TR/png-3/
//
// All rows take the Up filter: on photographs it compresses as well as libpng's choice per row and costs less. The
// filtered rows are cut into blocks of a fixed size, so that the bytes do not depend on the threads. Each block is
// deflated by itself, primed with the 32 KiB before it and ended on a byte (Z_SYNC_FLUSH), which makes the blocks one
// deflate stream when put in a row.
#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

#include "io/bands/band_tags.h"
#include "io/images/image_file.h"

namespace gpvc::io {

namespace {

constexpr std::size_t kWindow = 32768;                     // deflate's reach back
constexpr std::size_t kBlockBytes = std::size_t{1} << 20;  // large against the window, small against a page

void append_big_endian(std::string& out, std::size_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xFF);
}

void write_chunk(OutputFile& out, std::string_view name, std::string_view data) {
  std::string head;
  append_big_endian(head, data.size());
  head += name;
  uLong crc = crc32_z(0, reinterpret_cast<const Bytef*>(name.data()), name.size());
  // crc32_z would start a new checksum for a null pointer.
  if (!data.empty()) crc = crc32_z(crc, reinterpret_cast<const Bytef*>(data.data()), data.size());
  std::string tail;
  append_big_endian(tail, crc);
  out.write(head);
  out.write(data.data(), data.size());
  out.write(tail);
}

/// What is compressed.
struct PngPicture {
  int width = 0, height = 0, channels = 0;
  bool is_deep = false;  ///< samples of 16 bits, in this machine's byte order, of which PNG's is the other
  const std::uint8_t* samples = nullptr;

  std::size_t row_bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(channels) * (is_deep ? 2 : 1);
  }
};

/// Rows [first, last), each after its filter's number.
std::vector<std::uint8_t> filtered_rows(const PngPicture& picture, std::size_t first, std::size_t last) {
  const std::size_t row_bytes = picture.row_bytes();
  std::vector<std::uint8_t> out((last - first) * (row_bytes + 1));
  std::uint8_t* to = out.data();
  for (std::size_t y = first; y < last; ++y) {
    constexpr std::uint8_t kUp = 2;
    *to++ = kUp;
    const std::uint8_t* row = picture.samples + y * row_bytes;
    if (picture.is_deep) {
      for (std::size_t x = 0; x < row_bytes; ++x) {
        const std::size_t from = x ^ 1;
        const std::uint8_t above = y == 0 ? std::uint8_t{0} : *(row + from - row_bytes);
        to[x] = static_cast<std::uint8_t>(row[from] - above);
      }
    } else if (y == 0) {
      std::copy_n(row, row_bytes, to);
    } else {
      const std::uint8_t* above = row - row_bytes;
      for (std::size_t x = 0; x < row_bytes; ++x) to[x] = static_cast<std::uint8_t>(row[x] - above[x]);
    }
    to += row_bytes;
  }
  return out;
}

struct Block {
  std::string deflated;
  uLong adler = 0;
  std::size_t bytes = 0;  ///< before compression
};

Block deflate_rows(const PngPicture& picture, std::size_t first, std::size_t last) {
  const std::size_t line = picture.row_bytes() + 1;
  const std::size_t primer_rows = std::min(first, (kWindow + line - 1) / line);
  const std::vector<std::uint8_t> rows = filtered_rows(picture, first - primer_rows, last);
  const std::size_t primer = std::min(primer_rows * line, kWindow);
  const std::uint8_t* begin = rows.data() + primer_rows * line;
  Block block;
  block.bytes = (last - first) * line;
  block.adler = adler32_z(adler32_z(0, nullptr, 0), begin, block.bytes);

  z_stream stream{};
  constexpr int kRaw = -15, kMemory = 9, kFastest = 1;
  if (deflateInit2(&stream, kFastest, Z_DEFLATED, kRaw, kMemory, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
  if (primer > 0) deflateSetDictionary(&stream, begin - primer, static_cast<uInt>(primer));
  const bool end = last == static_cast<std::size_t>(picture.height);
  block.deflated.resize(deflateBound(&stream, static_cast<uLong>(block.bytes)) + 64);  // and the flush's marker
  stream.next_in = const_cast<Bytef*>(begin);
  stream.avail_in = static_cast<uInt>(block.bytes);
  stream.next_out = reinterpret_cast<Bytef*>(block.deflated.data());
  stream.avail_out = static_cast<uInt>(block.deflated.size());
  const int result = deflate(&stream, end ? Z_FINISH : Z_SYNC_FLUSH);
  block.deflated.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != (end ? Z_STREAM_END : Z_OK)) throw std::logic_error("deflate did not take a block whole");
  return block;
}

std::string header_of(const PngPicture& picture) {
  std::string header;
  append_big_endian(header, static_cast<std::size_t>(picture.width));
  append_big_endian(header, static_cast<std::size_t>(picture.height));
  constexpr std::array<char, 5> kColorTypes{0, 0, 4, 2, 6};  // by channels: grey, grey + alpha, RGB, RGBA
  const char color = kColorTypes.at(static_cast<std::size_t>(picture.channels));
  const char bits = picture.is_deep ? 16 : 8;
  return header + std::string{bits, color, 0, 0, 0};  // deflate, adaptive filters, not interlaced
}

/// A name, the compression's number, the profile as a zlib stream.
std::string profile_chunk(const ColorProfile& profile) {
  uLongf size = compressBound(static_cast<uLong>(profile.size()));
  std::string deflated(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(deflated.data()), &size, profile.data(), static_cast<uLong>(profile.size()),
                Z_BEST_COMPRESSION) != Z_OK)
    throw std::bad_alloc();
  deflated.resize(size);
  return std::string("ICC profile\0\0", 13) + deflated;
}

/// A keyword, no compression, no language, no translated keyword, the text in UTF-8.
std::string text_chunk(const std::string& keyword, const std::string& text) {
  return keyword + std::string(5, '\0') + text;
}

void write_picture(OutputFile& out, const PngPicture& picture, std::string_view about_name, std::string_view about) {
  const std::size_t line = picture.row_bytes() + 1;
  const auto height = static_cast<std::size_t>(picture.height);
  const std::size_t rows = std::max<std::size_t>(kBlockBytes / line, 1);
  std::vector<Block> blocks((height + rows - 1) / rows);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    blocks[i] = deflate_rows(picture, i * rows, std::min((i + 1) * rows, height));
  });
  out.write(std::string("\x89PNG\r\n\x1a\n", 8));
  write_chunk(out, "IHDR", header_of(picture));
  write_chunk(out, about_name, about);
  write_chunk(out, "IDAT", std::string("\x78\x01", 2));  // zlib: deflate with a 32 KiB window, fastest
  uLong adler = adler32_z(0, nullptr, 0);
  for (const Block& block : blocks) {
    write_chunk(out, "IDAT", block.deflated);
    adler = adler32_combine(adler, block.adler, static_cast<z_off_t>(block.bytes));
  }
  std::string check;
  append_big_endian(check, adler);
  write_chunk(out, "IDAT", check);
  write_chunk(out, "IEND", {});
}

}  // namespace

void write_png(OutputFile& out, const Image& image, const ColorProfile& profile) {
  const PngPicture picture{image.width, image.height, image.channels, false, image.pixels.data()};
  if (profile.empty())
    write_picture(out, picture, "sRGB", std::string(1, '\0'));  // perceptual
  else
    write_picture(out, picture, "iCCP", profile_chunk(profile));
}

void write_png(OutputFile& out, const Samples& samples, const BandSet& set) {
  const PngPicture picture{samples.width, samples.height, static_cast<int>(samples.bands),
                           samples.type == SampleType::u16,
                           reinterpret_cast<const std::uint8_t*>(samples.bytes.data())};
  write_picture(out, picture, "iTXt", text_chunk(kBandsKeyword, metadata_of(set)));
}

}  // namespace gpvc::io
