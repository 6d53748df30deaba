#include "io/images/image_bounds.h"

#include <algorithm>
#include <array>

#include "io/error.h"

namespace gpvc::io {
namespace {

std::string claim(std::int64_t width, std::int64_t height) {
  return "claims " + std::to_string(width) + " x " + std::to_string(height) + " pixels";
}

}  // namespace

std::uint32_t ImageBytes::big_endian(std::size_t at, std::size_t count) const {
  std::uint32_t value = 0;
  for (const char byte : view.substr(at, count)) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

void ImageBytes::fail(std::size_t at, const std::string& reason) const {
  throw InputError(file, (part.empty() ? "" : part + ", ") + "byte " + std::to_string(at), reason);
}

void check_png(const ImageBytes& image) {
  constexpr std::string_view kSignature = "\x89PNG\r\n\x1A\n";
  if (!image.is_png() || !kSignature.starts_with(image.view.substr(0, kSignature.size()))) return;
  std::uint32_t width = 0, height = 0, bits = 0, color = 0;
  std::uint64_t data_bytes = 0;
  for (std::size_t at = kSignature.size();;) {
    constexpr std::size_t kAround = 12;  // length, name and check sum
    const std::size_t left = image.view.size() - std::min(at, image.view.size());
    const std::size_t length = left < kAround ? 0 : image.big_endian(at, 4);
    if (length + kAround > left) image.fail(image.view.size(), "cannot be decoded whole: the PNG ends too early");
    const std::string_view name = image.view.substr(at + 4, 4);
    if (name == "IHDR" && length >= 10) {
      width = image.big_endian(at + 8, 4);
      height = image.big_endian(at + 12, 4);
      bits = image.big_endian(at + 16, 1);
      color = image.big_endian(at + 17, 1);
    }
    if (name == "IDAT") data_bytes += length;
    if (name == "IEND") break;
    at += length + kAround;
  }
  constexpr std::array<std::uint64_t, 7> kChannels{1, 0, 3, 1, 2, 0, 4};  // by IHDR's color type
  const std::uint64_t channels = color < kChannels.size() ? kChannels[color] : 0;
  check_size(image.file, image.part, width, height, std::max<std::int64_t>(static_cast<std::int64_t>(channels), 1));
  // Deflate at its densest codes a match of 258 bytes in two bits (length and distance), so 1032 bytes come from one.
  constexpr std::uint64_t kMostFromByte = 1032;
  if (std::uint64_t{width} * height * channels * bits / 8 > kMostFromByte * data_bytes)
    refuse_claim(image.file, image.part, width, height, data_bytes, " of data");
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

void refuse_claim(const std::filesystem::path& file, const std::string& place, std::int64_t width, std::int64_t height,
                  std::uint64_t bytes, const char* of_what) {
  throw InputError(
      file, place,
      claim(width, height) + ", more than its " + std::to_string(bytes) + " bytes" + of_what + " can hold");
}

}  // namespace gpvc::io
