// What image files claim, held against their bytes before anything is allocated or handed to a codec.
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
  /// Fills `to` from byte `at` on; false where that reaches beyond the end or cannot be read.
  std::function<bool(std::uint64_t at, std::span<unsigned char> to)> read{};

  /// InputError at a byte of the image.
  [[noreturn]] void fail(std::uint64_t at, const std::string& reason) const;
};

/// `view` must outlive the result.
ImageBytes bytes_in_memory(const std::filesystem::path& file, std::string part, std::string_view view);

/// Follows a PNG's chunks to its end, and holds the pixels that it claims against what its data can hold; passes what
/// is no PNG. libpng finds a cut too, but prints a line of its own and leaves by longjmp, which leaks in OpenImageIO.
/// Throws InputError.
void check_png(const ImageBytes& bytes);

/// The same for a JPEG, by its markers. libjpeg reports its first warning alone, so that a stray byte somewhere would
/// hide that the rest of the picture is missing. Nor does it report zeros in the place of data, as a failing disk or an
/// interrupted copy leaves them: runs of them that no picture is coded in are an error. Throws InputError. O(size).
void check_jpeg(const std::filesystem::path& file, const std::string& part, std::string_view view);

/// Holds the sizes in a JPEG's IPTC metadata against its segment, to be asked before OpenImageIO opens it, which up to
/// its 2.4.7 reads beyond the segment; passes what is no JPEG. Throws InputError. O(bytes before the first scan).
void check_jpeg_metadata(const std::filesystem::path& file, const std::string& part, std::string_view view);

/// Throws InputError at `place` unless 1 <= width, height and there are at most 2^30 pixels and 2^32 samples.
void check_size(const std::filesystem::path& file, const std::string& place, std::int64_t width, std::int64_t height,
                std::int64_t channels);

}  // namespace gpvc::io
