// Checks what the headers of image files claim against their bytes, before memory is allocated or a codec is called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace gpvc::io {

/// An image file, or an image inside another file; the bytes are borrowed.
struct ImageBytes {
  const std::filesystem::path& file;
  std::string part;  ///< "image 3 of the glTF"; empty for the whole file
  std::string_view view;

  bool is_jpeg() const { return view.starts_with("\xFF\xD8\xFF"); }
  bool is_png() const { return view.starts_with("\x89PNG"); }
  bool is_webp() const { return view.starts_with("RIFF") && view.size() >= 12 && view.substr(8, 4) == "WEBP"; }
  /// The number of `count` <= 4 bytes from byte `at` on, the highest first. \pre they are there
  std::uint32_t big_endian(std::size_t at, std::size_t count) const;
  /// Throws InputError for byte `at` of the image.
  [[noreturn]] void fail(std::size_t at, const std::string& reason) const;
};

/// Follows a PNG's chunks to its end and checks that its data can hold the pixels it claims; returns for files that are
/// not PNG. Throws InputError. O(chunks).
void check_png(const ImageBytes& image);

/// The same check for a JPEG, by its markers. libjpeg reports only its first warning, so a stray byte could hide that
/// the rest of the picture is missing. It does not report data overwritten with zeros either, as a failing disk or an
/// interrupted copy leaves it: a run of zeros that no encoder writes is an error. Throws InputError. O(size).
void check_jpeg(const ImageBytes& image);

/// Holds the strips or tiles of a TIFF that are compressed by deflate against the checksums that they end with, and decodes those
/// that are JPEGs as decode_jpeg() does; returns for other files. (LZW, PackBits and plain data tell nothing.) Throws InputError. O(bytes of pixels).
void check_tiff(const ImageBytes& image);

/// What zlib says of a stream that is damaged; empty for others. libtiff accepts a stream with a damaged end if
/// all pixels came out before it, and may read past the stream's last byte.
std::string deflate_damage(std::string_view deflated);
/// Throws InputError for it.
[[noreturn]] void refuse_damage(const std::filesystem::path& file, std::uint64_t at, const std::string& damage);

/// Throws InputError at `place` unless 1 <= width, height and there are at most 2^30 pixels and 2^32 samples.
void check_size(const std::filesystem::path& file, const std::string& place, std::int64_t width, std::int64_t height,
                std::int64_t channels);

/// Throws InputError at `place` for an image of more pixels than its bytes can hold.
[[noreturn]] void refuse_claim(const std::filesystem::path& file, const std::string& place, std::int64_t width,
                               std::int64_t height, std::uint64_t bytes, const char* of_what = "");

}  // namespace gpvc::io
