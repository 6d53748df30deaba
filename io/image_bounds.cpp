#include "io/image_bounds.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "io/error.h"

namespace gpvc {
namespace {

std::uint32_t big_endian(std::span<const unsigned char> bytes) {
  std::uint32_t value = 0;
  for (const unsigned char byte : bytes) value = value << 8 | byte;
  return value;
}

std::string claim(std::int64_t width, std::int64_t height) {
  return "claims " + std::to_string(width) + " x " + std::to_string(height) + " pixels";
}

/// PNG's IHDR: width, height, bits a sample, colour type.
struct PngHeader {
  std::uint32_t width = 0, height = 0;
  unsigned bits = 0, colour = 0;

  unsigned channels() const {
    constexpr std::array<unsigned, 7> kChannels{1, 0, 3, 1, 2, 0, 4};
    return colour < kChannels.size() ? kChannels[colour] : 0;
  }
};

void check_png_claim(const ImageBytes& bytes, const PngHeader& header, std::uint64_t data_bytes) {
  check_size(bytes.file, bytes.part, header.width, header.height, std::max(header.channels(), 1u));
  // Deflate's densest code: a length of 258 and its distance in a bit each, so 1032 bytes from one.
  constexpr std::uint64_t kMostFromByte = 1032;
  const std::uint64_t bits = std::uint64_t{header.width} * header.height * header.channels() * header.bits;
  if (bits / 8 > kMostFromByte * data_bytes)
    throw InputError(bytes.file, bytes.part,
                     claim(header.width, header.height) + ", more than its " + std::to_string(data_bytes) +
                         " bytes of data can hold");
}

/// The frame header behind marker 0xC0 .. 0xCF at `at`; tells nothing of what it does not know.
void check_jpeg_claim(const ImageBytes& bytes, std::uint64_t at, unsigned marker) {
  constexpr unsigned kHuffmanTables = 0xC4, kReserved = 0xC8, kArithmetic = 0xC9;
  if (marker < 0xC0 || marker > 0xCF || marker == kHuffmanTables || marker == kReserved || marker == 0xCC)
    return;
  std::array<unsigned char, 6> frame{};  // bits a sample, height, width, components
  if (!bytes.read(at + 4, frame)) return;
  const std::span<const unsigned char> fields = frame;
  const std::uint64_t height = big_endian(fields.subspan(1, 2)), width = big_endian(fields.subspan(3, 2));
  check_size(bytes.file, bytes.part, static_cast<std::int64_t>(width), static_cast<std::int64_t>(height),
             std::max<unsigned char>(frame[5], 1));
  // Every block of 8 x 8 samples has a Huffman code of a bit or more, and components of 4 x 1 and 1 x 4
  // sampling have the fewest blocks together, half of one a full block: 8 * 64 * 2 pixels from a byte.
  // Arithmetic coding knows no such bound.
  constexpr std::uint64_t kMostFromByte = 1024;
  if (marker < kArithmetic && width * height > kMostFromByte * bytes.size)
    throw InputError(bytes.file, bytes.part,
                     claim(static_cast<std::int64_t>(width), static_cast<std::int64_t>(height)) +
                         ", more than its " + std::to_string(bytes.size) + " bytes can hold");
}

}  // namespace

void ImageBytes::fail(std::uint64_t at, const std::string& reason) const {
  throw InputError(file, (part.empty() ? "" : part + ", ") + "byte " + std::to_string(at), reason);
}

ImageBytes bytes_in_memory(const std::filesystem::path& file, std::string part, std::string_view view) {
  return {file, std::move(part), view.size(), [view](std::uint64_t at, std::span<unsigned char> to) {
            if (at > view.size() || to.size() > view.size() - at) return false;
            std::memcpy(to.data(), view.data() + at, to.size());
            return true;
          }};
}

void check_png(const ImageBytes& bytes) {
  constexpr std::array<unsigned char, 8> kSignature{0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  std::array<unsigned char, 8> head{};
  const std::size_t given = std::min<std::uint64_t>(bytes.size, head.size());
  if (given < 4 || !bytes.read(0, std::span(head).first(given)) ||
      !std::equal(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(given), kSignature.begin()))
    return;
  PngHeader header;
  std::uint64_t data_bytes = 0;
  for (std::uint64_t at = kSignature.size();;) {
    constexpr std::uint64_t kAround = 12;  // length, name and check sum
    const bool whole = bytes.read(at, head);
    const std::uint64_t length = big_endian(std::span(head).first<4>());
    if (!whole || length + kAround > bytes.size - at)
      bytes.fail(bytes.size, "cannot be decoded whole: the PNG ends too early");
    const std::string_view name(reinterpret_cast<const char*>(head.data()) + 4, 4);
    std::array<unsigned char, 10> fields{};
    if (name == "IHDR" && length >= fields.size() && bytes.read(at + 8, fields))
      header = {big_endian(std::span(fields).first<4>()), big_endian(std::span(fields).subspan<4, 4>()),
                fields[8], fields[9]};
    if (name == "IDAT") data_bytes += length;
    if (name == "IEND") break;
    at += length + kAround;
  }
  check_png_claim(bytes, header, data_bytes);
}

void check_jpeg(const std::filesystem::path& file, const std::string& part, std::string_view view) {
  if (!view.starts_with("\xFF\xD8\xFF")) return;
  const ImageBytes bytes = bytes_in_memory(file, part, view);
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(view[i]); };
  for (std::size_t at = 2;;) {
    // Entropy-coded data and stray bytes lie between markers; a marker is 0xFF and neither 0x00 (a data
    // byte), 0xFF (fill), a restart D0 .. D7 nor 01. All but the end of the image carry their length.
    at = view.find('\xFF', at);
    if (at == std::string_view::npos || at + 1 >= view.size()) break;
    const unsigned marker = byte(at + 1);
    constexpr unsigned kEnd = 0xD9;
    if (marker == kEnd) return;
    const bool bare = marker <= 1 || (marker >= 0xD0 && marker <= 0xD8);
    if (marker == 0xFF) {
      ++at;
    } else if (bare) {
      at += 2;
    } else {
      check_jpeg_claim(bytes, at, marker);
      if (at + 3 >= view.size()) break;
      at += 2 + (std::size_t{byte(at + 2)} << 8 | byte(at + 3));
      if (at >= view.size()) break;
    }
  }
  bytes.fail(view.size(), "cannot be decoded whole: the JPEG ends too early");
}

void check_size(const std::filesystem::path& file, const std::string& place, std::int64_t width,
                std::int64_t height, std::int64_t channels) {
  if (width < 1 || height < 1 || channels < 1) throw InputError(file, place, "has no pixels");
  // 32768 x 32768: larger than any page or photo, and what a bare claim may cost.
  constexpr std::int64_t kMostPixels = std::int64_t{1} << 30, kMostSamples = std::int64_t{1} << 32;
  if (width > kMostPixels / height)
    throw InputError(file, place, claim(width, height) + ", expected at most 2^30");
  if (width * height > kMostSamples / channels)
    throw InputError(file, place,
                     claim(width, height) + " of " + std::to_string(channels) +
                         " channels, expected at most 2^32 samples");
}

}  // namespace gpvc
