// WebP, read and written through libwebp. https://developers.google.com/speed/webp/docs/riff_container
#include <webp/decode.h>
#include <webp/encode.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/images/codec.h"
#include "io/images/exif.h"
#include "io/images/image_file.h"

namespace gpvc::io {
namespace {

const std::uint8_t* data_of(const ImageBytes& image) {
  return reinterpret_cast<const std::uint8_t*>(image.view.data());
}

[[noreturn]] void refuse(const ImageBytes& image, const std::string& reason) {
  throw InputError(image.file, image.part, reason);
}

/// Calls use(name, data) for each chunk; what is cut off at the end is left to the decoder.
template <typename Use>
void for_each_chunk(std::string_view riff, const Use& use) {
  constexpr std::size_t kFirst = 12, kHead = 8;  // behind "RIFF", a size and "WEBP"; name and size
  for (std::size_t at = kFirst; at + kHead <= riff.size();) {
    std::uint32_t size = 0;
    std::memcpy(&size, riff.data() + at + 4, sizeof size);
    if (size > riff.size() - at - kHead) return;
    use(riff.substr(at, 4), riff.substr(at + kHead, size));
    at += kHead + size + size % 2;
  }
}

std::optional<float> exposure_value_of(std::string_view exif) {
  // With or without the words that begin a JPEG's EXIF data.
  constexpr std::string_view kBegin("Exif\0\0", 6);
  std::string data(exif.starts_with(kBegin) ? "" : kBegin);
  data += exif;
  return exposure_value({reinterpret_cast<const std::uint8_t*>(data.data()), data.size()});
}

/// What libwebp has made, freed at the end.
struct Encoding {
  WebPPicture picture{};
  WebPMemoryWriter bytes{};
  Encoding() {
    WebPPictureInit(&picture);
    WebPMemoryWriterInit(&bytes);
  }
  ~Encoding() {
    WebPPictureFree(&picture);
    WebPMemoryWriterClear(&bytes);
  }
  Encoding(const Encoding&) = delete;
  Encoding& operator=(const Encoding&) = delete;
};

}  // namespace

ImageHeader read_webp_header(const ImageBytes& image) {
  WebPBitstreamFeatures found{};
  if (WebPGetFeatures(data_of(image), image.view.size(), &found) != VP8_STATUS_OK)
    refuse(image, "is no WebP that can be read");
  if (found.has_animation != 0) refuse(image, "is a WebP that moves, expected a picture");
  ImageHeader header;
  header.format = "webp";
  header.width = found.width;
  header.height = found.height;
  header.channels = found.has_alpha != 0 ? 4 : 3;
  header.alpha_channel = found.has_alpha != 0 ? 3 : -1;
  for_each_chunk(image.view, [&](std::string_view name, std::string_view data) {
    if (name == "ICCP") header.profile.assign(data.begin(), data.end());
    if (name == "EXIF") header.exposure_value = exposure_value_of(data);
  });
  // The densest are pictures of one colour, a few bytes for a row of blocks.
  constexpr std::int64_t kMostFromByte = 1 << 20;
  if (std::int64_t{found.width} * found.height * header.channels / kMostFromByte >
      static_cast<std::int64_t>(image.view.size()))
    refuse_claim(image.file, image.part, found.width, found.height, image.view.size());
  return header;
}

void decode_webp(const ImageBytes& image, int channels, std::uint8_t* to) {
  int width = 0, height = 0;
  if (WebPGetInfo(data_of(image), image.view.size(), &width, &height) == 0)
    refuse(image, "is no WebP that can be read");
  const std::size_t row = static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
  const auto decode = channels == 4 ? WebPDecodeRGBAInto : WebPDecodeRGBInto;
  if (decode(data_of(image), image.view.size(), to, row * static_cast<std::size_t>(height), static_cast<int>(row)) ==
      nullptr)
    refuse(image, "cannot be decoded whole: the WebP ends too early, or is damaged");
}

void write_webp(OutputFile& out, const std::filesystem::path& file, const Image& image, int quality) {
  const auto fail = [&](const std::string& why) { throw OutputError(file, "cannot be encoded as WebP: " + why); };
  static_assert(kMostWebpEdge == WEBP_MAX_DIMENSION);
  if (std::max(image.width, image.height) > kMostWebpEdge)
    fail("it has " + size_text(image.width, image.height) + " pixels, and an edge has at most " +
         std::to_string(kMostWebpEdge));
  WebPConfig config;
  if (WebPConfigInit(&config) == 0) fail("libwebp is of another version");
  config.quality = static_cast<float>(quality);
  // On a page of a park, 4096 x 4096, at quality 85: 38.4 dB in 3.2 MB after 2.5 s; with libwebp's own strengths of noise shaping
  // and deblocking, which are made for how a picture looks and not for what a page shows enlarged, 36.3 dB in 3.3 MB; with
  // method 2, 38.0 dB in 4.2 MB after 1.2 s. A JPEG of 38.4 dB has 4.2 MB.
  config.method = 4;
  config.sns_strength = 0;
  config.filter_strength = 0;
  Encoding encoding;
  WebPPicture& picture = encoding.picture;
  picture.width = image.width;
  picture.height = image.height;
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &encoding.bytes;
  if (WebPPictureImportRGB(&picture, image.pixels.data(), 3 * image.width) == 0 || WebPEncode(&config, &picture) == 0)
    fail(picture.error_code == VP8_ENC_ERROR_OUT_OF_MEMORY ? "there is too little memory"
                                                           : "error " + std::to_string(picture.error_code));
  out.write(encoding.bytes.mem, encoding.bytes.size);
}

}  // namespace gpvc::io
