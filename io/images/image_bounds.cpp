#include "io/images/image_bounds.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "io/error.h"

namespace gpvc::io {
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
  unsigned bits = 0, color = 0;

  unsigned channels() const {
    constexpr std::array<unsigned, 7> kChannels{1, 0, 3, 1, 2, 0, 4};
    return color < kChannels.size() ? kChannels[color] : 0;
  }
};

void check_png_claim(const ImageBytes& bytes, const PngHeader& header, std::uint64_t data_bytes) {
  check_size(bytes.file, bytes.part, header.width, header.height, std::max(header.channels(), 1u));
  // Deflate at its densest codes a match of 258 bytes in two bits (length and distance), so 1032 bytes come from one.
  constexpr std::uint64_t kMostFromByte = 1032;
  const std::uint64_t bits = std::uint64_t{header.width} * header.height * header.channels() * header.bits;
  if (bits / 8 > kMostFromByte * data_bytes)
    throw InputError(bytes.file, bytes.part,
                     claim(header.width, header.height) + ", more than its " + std::to_string(data_bytes) +
                         " bytes of data can hold");
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
      header = {big_endian(std::span(fields).first<4>()), big_endian(std::span(fields).subspan<4, 4>()), fields[8],
                fields[9]};
    if (name == "IDAT") data_bytes += length;
    if (name == "IEND") break;
    at += length + kAround;
  }
  check_png_claim(bytes, header, data_bytes);
}

void check_size(const std::filesystem::path& file, const std::string& place, std::int64_t width, std::int64_t height,
                std::int64_t channels) {
  if (width < 1 || height < 1 || channels < 1) throw InputError(file, place, "has no pixels");
  // 32768 x 32768: larger than any page or photo; it bounds the memory that a false claim can cost.
  constexpr std::int64_t kMostPixels = std::int64_t{1} << 30, kMostSamples = std::int64_t{1} << 32;
  if (width > kMostPixels / height) throw InputError(file, place, claim(width, height) + ", expected at most 2^30");
  if (width * height > kMostSamples / channels)
    throw InputError(
        file, place,
        claim(width, height) + " of " + std::to_string(channels) + " channels, expected at most 2^32 samples");
}

}  // namespace gpvc::io
