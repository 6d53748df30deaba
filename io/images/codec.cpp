#include "io/images/codec.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "io/error.h"
#include "io/images/exif.h"
#include "io/images/image_file.h"
#include "io/images/other_formats.h"

namespace gpvc::io {
namespace {

/// The formats accepted for photos, masks and pages, besides JPEG, PNG and WebP. OpenImageIO alone would try all of its formats on a
/// file, and some of them, above all Targa, accept any bytes and believe the size that they find there.
struct Codec {
  std::string_view name;
  std::int64_t most_from_byte;  ///< samples that a byte can hold
};
// Deflate and simpler codings make at most 1032 bytes from one, each of 8 one-bit samples; the densest block of zstd
// makes 128 KiB from four bytes; fax coding spends one bit on a white row.
constexpr std::int64_t kPlain = 8 * 1032, kDense = 1 << 20;
constexpr Codec kCodecs[] = {{"tiff", kDense},     {"openexr", kDense}, {"raw", kDense}, {"heif", kDense},
                             {"jpeg2000", kDense}, {"bmp", kPlain},     {"hdr", kPlain}, {"pnm", kPlain},
                             {"psd", kPlain},      {"dpx", kPlain}};

/// Refuses what cannot be read as a picture, and a size that the file cannot hold before memory is allocated for it.
void check_claims(const ImageBytes& image, const OtherHeader& header) {
  const auto* codec = std::ranges::find(kCodecs, header.format, &Codec::name);
  const auto fail = [&](const std::string& reason) { throw InputError(image.file, image.part, reason); };
  if (codec == std::end(kCodecs))
    fail("is no image that can be read, at most a " + header.format +
         " by chance; expected JPEG, PNG, TIFF, EXR or the like");
  if (header.depth > 1) fail("is a volume, expected an image");
  check_size(image.file, image.part, header.width, header.height, header.channels);
  const std::int64_t samples = std::int64_t{header.width} * header.height * header.channels;
  if (static_cast<std::uintmax_t>(samples / codec->most_from_byte) > image.view.size())
    refuse_claim(image.file, image.part, header.width, header.height, image.view.size());
  if (!header.whole) fail("its data window is not its display window, expected the whole picture and no more");
  if (header.raw)
    fail(
        "is a camera's raw photo, which OpenImageIO reads only when it is built with LibRaw and the name ends like "
        ".dng; expected that, or a JPEG, PNG or TIFF made of it");
}

ImageHeader read_other_header(const ImageBytes& image) {
  if (!image.part.empty()) throw InputError(image.file, image.part, "expected a PNG, JPEG or WebP");
  // OpenImageIO believes the size that a GIF claims as soon as it opens it.
  if (image.view.starts_with("GIF8"))
    throw InputError(image.file, "", "is a GIF, expected JPEG, PNG, TIFF, EXR or the like");
  OtherHeader found;
  if (!read_tiff_header(image, found))
    if (const std::string wrong = other_formats(image.file).read_header(image.file, found); !wrong.empty())
      throw InputError(image.file, "", "is no image that can be read: " + wrong);
  check_claims(image, found);
  return {std::move(found.format),
          found.width,
          found.height,
          found.channels,
          found.bits,
          found.alpha_channel,
          found.linear_light,
          std::move(found.profile),
          exposure_value(found.exposure_seconds, found.f_number, found.sensitivity),
          found.type,
          std::move(found.type_name),
          found.colors,
          std::move(found.bands),
          found.nodata,
          found.has_mask};
}

constexpr const char* kNotWhole = "cannot be decoded whole: ";

void decode_other(const ImageBytes& image, const SampleRoom& room, std::string_view format) {
  if (format == "tiff") check_tiff(image);
  std::string wrong;
  if (!decode_tiff(image, room, wrong)) wrong = other_formats(image.file).decode(image.file, room);
  if (!wrong.empty()) throw InputError(image.file, image.part, kNotWhole + wrong);
}

}  // namespace

ImageHeader read_header(const ImageBytes& image) {
  if (image.view.empty()) throw InputError(image.file, image.part, "is empty, expected an image");
  check_png(image);
  ImageHeader header = image.is_jpeg()   ? read_jpeg_header(image)
                       : image.is_png()  ? read_png_header(image)
                       : image.is_webp() ? read_webp_header(image)
                                         : read_other_header(image);
  check_size(image.file, image.part, header.width, header.height, header.channels);
  return header;
}

void refuse_other_types(const ImageBytes& image, const ImageHeader& header) {
  if (!header.type)
    throw InputError(image.file, image.part,
                     "holds samples of type " + header.type_name +
                         "; expected whole numbers of 8 or 16 bits without a sign, or floats");
}

void decode_samples(const ImageBytes& image, const ImageHeader& header, int channels, std::uint8_t* to) {
  if (header.format == "jpeg")
    decode_jpeg(image, header, to);
  else if (header.format == "png")
    decode_png(image, header, to);
  else if (header.format == "webp")
    decode_webp(image, channels, to);
  else
    decode_other(image, {header.width, header.height, channels, SampleForm::bytes, to}, header.format);
}

void decode_samples(const ImageBytes& image, const ImageHeader& header, int channels, float* to) {
  if (header.format == "png")
    decode_png(image, header, to);
  else
    decode_other(image, {header.width, header.height, channels, SampleForm::reals, to}, header.format);
}

PhotoExclusion decode_mask(const ImageBytes& image, const ImageHeader& header) {
  PhotoExclusion masked = empty_exclusion(header.width, header.height);
  if (const std::string wrong = decode_tiff_mask(image, masked); !wrong.empty())
    throw InputError(image.file, image.part, "has a mask that cannot be decoded whole: " + wrong);
  return masked;
}

void decode_stored(const std::filesystem::path& file, const ImageHeader& header, std::byte* to) {
  const SampleRoom room{header.width, header.height, header.channels, SampleForm::stored, to};
  std::string wrong;
  if (header.format == "tiff" && decode_tiff_in_parts(file, room, wrong)) {
    if (!wrong.empty()) throw InputError(file, "", kNotWhole + wrong);
    return;
  }
  const FileBytes bytes = image_bytes(file, FileBytes::Use::whole);
  const ImageBytes image{file, "", bytes.view()};
  if (header.format == "png" && header.bits == 16)
    decode_png(image, header, reinterpret_cast<std::uint16_t*>(to));
  else if (header.format == "jpeg" || header.format == "png" || header.format == "webp")
    decode_samples(image, header, header.channels, reinterpret_cast<std::uint8_t*>(to));
  else
    decode_other(image, room, header.format);
}

}  // namespace gpvc::io
