// Reads pixels of files and of images inside files: JPEG, PNG, TIFF and WebP through their own libraries, all else through
// other_formats.h.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "io/images.h"
#include "io/images/image_bounds.h"
#include "io/images/other_formats.h"
#include "io/photos.h"

namespace gpvc::io {

struct ImageHeader {
  std::string format;  ///< "jpeg", "png", "webp", or OpenImageIO's name
  int width = 0, height = 0, channels = 0;
  int bits = 8;            ///< a sample; 0: no integers
  int alpha_channel = -1;  ///< -1: none
  bool linear_light = false;
  ColorProfile profile;                             ///< empty: none
  std::optional<float> exposure_value{};            ///< as in View
  std::optional<SampleType> type = SampleType::u8;  ///< u8, u16 or f32; nullopt: samples of another type
  std::string type_name{};                          ///< that of OtherHeader, as what follows
  bool colors = true;
  std::vector<Band> bands{};
  std::optional<double> nodata{};
  bool has_mask = false;
};

/// Goes by the bytes, not by the name, and checks what they claim. Throws InputError, also for formats that are not accepted.
ImageHeader read_header(const ImageBytes& image);

/// Throws InputError for samples of another type than those of ImageHeader::type.
void refuse_other_types(const ImageBytes& image, const ImageHeader& header);

/// Decodes the first `channels` of an image that read_header() knows. A JPEG's, PNG's or WebP's have to be all of them, and a JPEG or
/// 8-bit image does not become floats. Throws InputError unless the whole picture could be decoded. \pre check_jpeg(image)
void decode_samples(const ImageBytes& image, const ImageHeader& header, int channels, std::uint8_t* to);
void decode_samples(const ImageBytes& image, const ImageHeader& header, int channels, float* to);
/// Excludes the pixels that the file's own mask does. Throws InputError. \pre header.has_mask
PhotoExclusion decode_mask(const ImageBytes& image, const ImageHeader& header);
/// All channels, the samples as they are stored; of most TIFFs without holding the file. \pre header.type
void decode_stored(const std::filesystem::path& file, const ImageHeader& header, std::byte* to);

/// Parts of the two above. Printers' inks come as RGB, palettes too; what libjpeg and libpng find wrong that may cost a pixel is an
/// InputError.
ImageHeader read_jpeg_header(const ImageBytes& image);
void decode_jpeg(const ImageBytes& image, const ImageHeader& header, std::uint8_t* to);
ImageHeader read_png_header(const ImageBytes& image);
void decode_png(const ImageBytes& image, const ImageHeader& header, std::uint8_t* to);
void decode_png(const ImageBytes& image, const ImageHeader& header, float* to);
void decode_png(const ImageBytes& image, const ImageHeader& header, std::uint16_t* to);  ///< \pre header.bits == 16

ImageHeader read_webp_header(const ImageBytes& image);
/// 3 channels, or 4 where there is an alpha channel.
void decode_webp(const ImageBytes& image, int channels, std::uint8_t* to);

/// Both return false for files that are no TIFF, or one that is left to OpenImageIO. \param wrong what is wrong, or nothing, as those of
/// OtherFormats return it
bool read_tiff_header(const ImageBytes& image, OtherHeader& header);
bool decode_tiff(const ImageBytes& image, const SampleRoom& room, std::string& wrong);

/// decode_tiff() with no more of the file in memory than a strip or a tile, and what check_tiff() checks. Returns false also for files
/// of which the latter needs more. Throws InputError.
bool decode_tiff_in_parts(const std::filesystem::path& file, const SampleRoom& room, std::string& wrong);

/// Adds the pixels that the file's own mask excludes to `masked`, which has its size. Returns what is wrong, or nothing.
std::string decode_tiff_mask(const ImageBytes& image, PhotoExclusion& masked);

}  // namespace gpvc::io
