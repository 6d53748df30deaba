// Photos of any depth and number of bands as TIFF, by libtiff.
#pragma once

#include <gtest/gtest.h>
#include <tiffio.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "io/samples.h"

namespace gpvc::test {

/// How the samples lie in the file, and what it says of them.
struct TiffLayout {
  std::uint16_t coding = COMPRESSION_NONE, predictor = PREDICTOR_NONE, planes = PLANARCONFIG_CONTIG;
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  std::vector<std::uint16_t> extra{};  ///< of all samples beyond the colours; else none is stated
  bool states_extra = true;            ///< where `extra` is empty: further samples are unspecified
  std::uint32_t tile = 0;              ///< edge, a multiple of 16; 0: strips
  const char* mode = "w";              ///< "w8" BigTIFF, "wb" big-endian
  std::string metadata{}, nodata{}, xmp{};
};

template <typename T>
std::vector<std::byte> bytes_in(const std::vector<T>& samples) {
  std::vector<std::byte> bytes(samples.size() * sizeof(T));
  std::memcpy(bytes.data(), samples.data(), bytes.size());
  return bytes;
}

inline void write_tiff(const std::filesystem::path& file, const Samples& samples, const TiffLayout& layout = {}) {
  std::filesystem::create_directories(file.parent_path());
  TIFF* tiff = TIFFOpen(file.c_str(), layout.mode);
  ASSERT_NE(tiff, nullptr);
  static const TIFFFieldInfo kFields[] = {
      {42112, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("GDALMetadata")},
      {42113, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("GDALNoDataValue")}};
  TIFFMergeFieldInfo(tiff, kFields, 2);
  const auto bands = static_cast<std::uint16_t>(samples.bands);
  const std::size_t size = bytes_of(samples.type);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, samples.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, samples.height);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, bands);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<std::uint16_t>(8 * size));
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
               samples.type == SampleType::f32   ? SAMPLEFORMAT_IEEEFP
               : samples.type == SampleType::u32 ? SAMPLEFORMAT_INT
                                                 : SAMPLEFORMAT_UINT);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, layout.photometric);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, layout.planes);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, layout.coding);
  if (layout.predictor != PREDICTOR_NONE) TIFFSetField(tiff, TIFFTAG_PREDICTOR, layout.predictor);
  const std::uint16_t colors = layout.photometric == PHOTOMETRIC_RGB ? 3 : 1;
  std::vector<std::uint16_t> extra = layout.extra;
  if (extra.empty() && layout.states_extra && bands > colors)
    extra.assign(static_cast<std::size_t>(bands - colors), EXTRASAMPLE_UNSPECIFIED);
  if (!extra.empty()) TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, static_cast<std::uint16_t>(extra.size()), extra.data());
  if (!layout.metadata.empty()) TIFFSetField(tiff, 42112, layout.metadata.c_str());
  if (!layout.nodata.empty()) TIFFSetField(tiff, 42113, layout.nodata.c_str());
  if (!layout.xmp.empty())
    TIFFSetField(tiff, TIFFTAG_XMLPACKET, static_cast<std::uint32_t>(layout.xmp.size()), layout.xmp.data());
  const bool apart = layout.planes == PLANARCONFIG_SEPARATE;
  const int planes = apart ? bands : 1;
  const std::size_t each = apart ? size : samples.pixel_bytes();  // bytes of a pixel in a strip or tile
  const int across = layout.tile > 0 ? static_cast<int>(layout.tile) : samples.width;
  const int down = layout.tile > 0 ? static_cast<int>(layout.tile) : 5;
  if (layout.tile > 0) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, layout.tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, layout.tile);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, down);
  }
  for (int plane = 0; plane < planes; ++plane)
    for (int top = 0; top < samples.height; top += down)
      for (int left = 0; left < samples.width; left += across) {
        const int rows = layout.tile > 0 ? down : std::min(down, samples.height - top);
        std::vector<std::byte> part(each * static_cast<std::size_t>(across * rows));
        for (int y = 0; y < std::min(rows, samples.height - top); ++y)
          for (int x = 0; x < std::min(across, samples.width - left); ++x)
            std::memcpy(&part[each * pixel_index(x, y, across)],
                        samples.at(left + x, top + y) + (apart ? size * static_cast<std::size_t>(plane) : 0), each);
        const auto bytes = static_cast<tmsize_t>(part.size());
        const auto at_x = static_cast<std::uint32_t>(left), at_y = static_cast<std::uint32_t>(top);
        const auto of_plane = static_cast<std::uint16_t>(plane);
        const tmsize_t written =
            layout.tile > 0
                ? TIFFWriteEncodedTile(tiff, TIFFComputeTile(tiff, at_x, at_y, 0, of_plane), part.data(), bytes)
                : TIFFWriteEncodedStrip(tiff, TIFFComputeStrip(tiff, at_y, of_plane), part.data(), bytes);
        ASSERT_EQ(written, bytes);
      }
  TIFFClose(tiff);
}

/// Adds a mask to a TIFF as GDAL does: a picture of its own behind a smaller one, 1 or 255 where `shows(x, y)`. \param bits 1 or 8
/// \param tile as in TiffLayout
template <typename Shows>
void append_mask(const std::filesystem::path& file, int width, int height, const Shows& shows, int bits = 1,
                 std::uint32_t tile = 0) {
  TIFF* tiff = TIFFOpen(file.c_str(), "a");
  ASSERT_NE(tiff, nullptr);
  const auto write = [&](int columns, int rows, std::uint32_t kind, std::uint16_t photometric, int depth) {
    const int across = tile > 0 ? static_cast<int>(tile) : columns, down = tile > 0 ? static_cast<int>(tile) : 7;
    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, kind);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, columns);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, rows);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, depth);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, photometric);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    if (tile > 0) {
      TIFFSetField(tiff, TIFFTAG_TILEWIDTH, tile);
      TIFFSetField(tiff, TIFFTAG_TILELENGTH, tile);
    } else {
      TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, down);
    }
    const int row = depth == 8 ? across : (across + 7) / 8;
    std::uint32_t number = 0;
    for (int top = 0; top < rows; top += down)
      for (int left = 0; left < columns; left += across) {
        const int lines = tile > 0 ? down : std::min(down, rows - top);
        std::vector<std::uint8_t> part(static_cast<std::size_t>(row * lines));
        for (int y = 0; y < std::min(lines, rows - top); ++y)
          for (int x = 0; x < std::min(across, columns - left); ++x)
            if (shows(left + x, top + y))
              part[static_cast<std::size_t>(row * y + (depth == 8 ? x : x / 8))] |=
                  static_cast<std::uint8_t>(depth == 8 ? 255 : 0x80 >> x % 8);
        const auto bytes = static_cast<tmsize_t>(part.size());
        const tmsize_t written = tile > 0 ? TIFFWriteEncodedTile(tiff, number, part.data(), bytes)
                                          : TIFFWriteEncodedStrip(tiff, number, part.data(), bytes);
        ASSERT_EQ(written, bytes);
        ++number;
      }
    TIFFWriteDirectory(tiff);
  };
  write(width / 2, height / 2, FILETYPE_REDUCEDIMAGE, PHOTOMETRIC_MINISBLACK, 8);
  write(width / 2, height / 2, FILETYPE_REDUCEDIMAGE | FILETYPE_MASK, PHOTOMETRIC_MASK, bits);
  write(width, height, FILETYPE_MASK, PHOTOMETRIC_MASK, bits);
  TIFFClose(tiff);
}

}  // namespace gpvc::test
