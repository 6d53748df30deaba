// Image files: reading, writing, color profiles.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "error.h"
#include "image.h"
#include "names.h"
#include "samples.h"

namespace gpvc::io {

/// Decodes a photo to 3 channels of 8 bits: grey is repeated, alpha dropped, deeper samples scaled with rounding; linear
/// light (EXR, HDR) gets sRGB's curve, with 1 as white. EXIF orientation is not applied, to raw photos (DNG) neither
/// (cameras are calibrated on the stored pixels). Throws InputError on a truncated file, on a JPEG part of whose data has
/// been overwritten with zeros (where its Huffman tables show it), and on a claim of more pixels than the file can hold,
/// or than 2^30. Raw photos need an OpenImageIO with LibRaw.
Image read_image(const std::filesystem::path& file);

/// Decodes all bands of a photo, and no alpha, as the file stores them: u8, u16 or f32, halves and doubles as f32; 0 for what is no
/// number. EXIF orientation is not applied. Throws InputError as read_image does, and for samples of other types.
Samples read_samples(const std::filesystem::path& file);

/// Throws InputError if the photo is a JPEG or PNG that ends too early. Of a JPEG reads the last 64 KiB, where the end marker
/// is, and the whole file only if it is not; of a PNG the heads of its chunks.
void check_photo_end(const std::filesystem::path& file);

struct ImageSize {
  int width = 0, height = 0;
  bool operator==(const ImageSize&) const = default;
};
/// As stored: EXIF orientation is not applied. From the header alone. Throws InputError.
ImageSize read_image_size(const std::filesystem::path& file);

/// From the header alone. Throws InputError.
bool has_alpha(const std::filesystem::path& file);

/// True if the file says which of its pixels show nothing: by an alpha, or, of a TIFF, by a mask of its own as GDAL writes it.
/// From the header alone. Throws InputError.
bool hides_pixels(const std::filesystem::path& file);

/// Of the photo by its EXIF data, as in View; nullopt where that does not state it. Throws InputError.
std::optional<float> read_exposure_value(const std::filesystem::path& file);

/// True if a pixel has one colour channel. From the header alone. Throws InputError.
bool is_grey(const std::filesystem::path& file);

/// True if the name ends like an image's: .jpg, .tif, .dng and others, in upper or lower case. Any other text behind the
/// last dot is part of the name.
bool has_image_extension(const std::filesystem::path& name);

/// Every `factor` x `factor` block averaged with rounding to nearest; a remainder at the right and bottom is cut. \pre
/// 1 <= factor <= width, height
Image reduce_image(const Image& image, int factor);

/// What a view of an equirectangular panorama (see is_spherical) takes for its photo: the panorama with some of its left
/// columns repeated on the right, and the other way round.
Image continue_around(const Image& panorama);

/// An ICC profile, byte for byte as image files embed it; empty: none.
using ColorProfile = std::vector<std::uint8_t>;

/// From the header alone. Also empty for a profile that is not of RGB colours (grey and CMYK photos come converted).
/// Throws InputError.
ColorProfile read_color_profile(const std::filesystem::path& file);

enum class ImageFormat { png, jpg, webp };
inline constexpr Named<ImageFormat> kImageFormatNames[] = {
    {"jpg", ImageFormat::jpg}, {"png", ImageFormat::png}, {"webp", ImageFormat::webp}};

/// Texels of a WebP's edge, at most.
inline constexpr int kMostWebpEdge = 16383;

/// `quality` 1..100 applies to jpg (chroma is not subsampled) and webp (of 3 channels; chroma is halved). `profile` is
/// embedded in jpg and png; without one, PNG says sRGB and the others nothing, which means the same. Throws OutputError.
void write_image(const std::filesystem::path& file, const Image& image, ImageFormat format, int quality,
                 const ColorProfile& profile = {});

/// What a file's samples are by its header and tags alone, whose bands are an alpha's as well; nothing of BandSet that photos have
/// in common. Throws InputError.
BandSet read_band_set(const std::filesystem::path& file);

/// What photos in memory have in common, by the rules for photos in files. \param composite names or numbers of the bands that are looked
/// at; empty: by their names \param some samples of several photos, for the range. Throws InputError.
BandSet band_set_of(std::vector<Band> bands, SampleType type, const std::vector<std::string>& composite,
                    std::vector<float> some);

/// What is looked at of samples: the composite's bands, black to white as 0 to 255. 3 channels. O(pixels).
Image picture_of(const Samples& samples, const BandSet& bands);

/// The formats of samples. A PNG holds 1 to 4 bands of 8 or 16 bits.
enum class SampleFormat { tif, png };
inline constexpr Named<SampleFormat> kSampleFormatNames[] = {{"tif", SampleFormat::tif}, {"png", SampleFormat::png}};
bool fits_png(const BandSet& bands);

/// A TIFF with the bands of each pixel together, in deflate and without loss; names, wavelengths and units of the bands are where GDAL
/// reads them. `mask`: per pixel, 0 where it has no value; becomes the file's own mask. Empty: none. BigTIFF where it is larger than
/// 4 GB. A file called .png becomes one, without the mask and with the same text of its bands: 2 and 4 of them lie where other
/// programs look for grey or RGB with an alpha, read_samples() takes them for bands by this text. Throws OutputError.
/// \pre of a PNG: fits_png(bands)
void write_samples(const std::filesystem::path& file, const Samples& samples, const BandSet& bands,
                   std::span<const std::uint8_t> mask = {});

/// Adds EXIF data to a JPEG that write_image() wrote: the exposure time, the f-number and the ISO speed. Throws InputError,
/// OutputError.
void state_exposure(const std::filesystem::path& jpeg, double seconds, double f_number, std::uint32_t sensitivity);

}  // namespace gpvc::io
