// Checks what the headers of image files claim against their bytes, before memory is allocated or a codec is called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace gpvc::io {

/// Bytes of an image that lie in a file, or in a part of one.
struct ImageBytes {
  const std::filesystem::path& file;
  std::string part;        ///< "image 3 of the glTF"; empty for the whole file
  std::uint64_t size = 0;  ///< bytes
  /// Fills `to` from byte `at` on; false if that goes beyond the end or cannot be read.
  std::function<bool(std::uint64_t at, std::span<unsigned char> to)> read{};

  /// Throws InputError for byte `at` of the image.
  [[noreturn]] void fail(std::uint64_t at, const std::string& reason) const;
};

/// `view` must outlive the result.
ImageBytes bytes_in_memory(const std::filesystem::path& file, std::string part, std::string_view view);

/// Follows a PNG's chunks to its end and checks that its data can hold the pixels it claims; returns for files that are
/// not PNG. libpng finds a truncated file too, but prints a line of its own and leaves by longjmp, which leaks in
/// OpenImageIO. Throws InputError.
void check_png(const ImageBytes& bytes);

/// The same check for a JPEG, by its markers. libjpeg reports only its first warning, so a stray byte could hide that
/// the rest of the picture is missing. It does not report data overwritten with zeros either, as a failing disk or an
/// interrupted copy leaves it: a run of zeros that no encoder writes is an error. Throws InputError. O(size).
void check_jpeg(const std::filesystem::path& file, const std::string& part, std::string_view view);

/// Checks the sizes in a JPEG's IPTC metadata against their segment; returns for files that are not JPEG. To be called
/// before OpenImageIO opens the file: up to version 2.4.7 it reads beyond the segment. Throws InputError. O(bytes
/// before the first scan).
void check_jpeg_metadata(const std::filesystem::path& file, const std::string& part, std::string_view view);

/// Throws InputError at `place` unless 1 <= width, height and there are at most 2^30 pixels and 2^32 samples.
void check_size(const std::filesystem::path& file, const std::string& place, std::int64_t width, std::int64_t height,
                std::int64_t channels);

}  // namespace gpvc::io
