// Image formats other than JPEG and PNG: TIFF, EXR, raw photos and more, by OpenImageIO.
//
// It loads 260 libraries, which takes a program a third of a second at each start. So what calls it is a module, which is
// opened where a file of such a format is read; static libraries are linked with it (io/CMakeLists.txt). The module has no
// other code of this tree, and no exception leaves it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/samples.h"

namespace gpvc::io {

struct OtherHeader {
  std::string format;  ///< OpenImageIO's name
  int width = 0, height = 0, depth = 0, channels = 0;
  int bits = 0;                       ///< a sample; 0: no integers
  int alpha_channel = -1;             ///< -1: none
  bool linear_light = false;          ///< EXR, HDR
  bool whole = true;                  ///< the pixels that the file holds are all that the picture shows
  bool raw = false;                   ///< of a sensor, and not developed
  std::vector<std::uint8_t> profile;  ///< ICC; empty: none
  std::optional<SampleType> type{};   ///< of SampleForm::stored; nullopt: neither u8, u16 nor a float
  std::string type_name{};            ///< where it is nullopt: "int16"
  bool colors = true;                 ///< the first channels are grey or red, green and blue
  std::vector<Band> bands{};          ///< what the file says of its channels, one each; empty: nothing
  std::optional<double> nodata{};     ///< the sample of pixels without a value
  bool has_mask = false;              ///< the file holds a mask of its pixels, beside any alpha
  double exposure_seconds = 0, f_number = 0, sensitivity = 0;  ///< by EXIF data; 0: unknown
};

/// bytes: 0 black, 255 white; reals: floats, of whole numbers 0 black, 1 white; stored: the numbers of the file, halves and
/// doubles as floats.
enum class SampleForm : std::uint8_t { bytes, reals, stored };

/// Where samples go: the first `channels` of each pixel.
struct SampleRoom {
  int width = 0, height = 0, channels = 0;
  SampleForm form = SampleForm::bytes;
  void* samples = nullptr;
};

/// Both return what is wrong, in a line without the file's name, or nothing. Thread-safe.
struct OtherFormats {
  std::string (*read_header)(const std::filesystem::path& file, OtherHeader& header);
  /// \pre there is room for what read_header said, or for its first channels
  std::string (*decode)(const std::filesystem::path& file, const SampleRoom& room);
};

/// Throws InputError, which names `file` as what needs them, if the module can't be opened.
const OtherFormats& other_formats(const std::filesystem::path& file);

}  // namespace gpvc::io

/// What the module exports.
extern "C" [[gnu::visibility("default")]] const gpvc::io::OtherFormats* gpvc_other_formats();
