#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <string_view>

#include "io/images/other_formats.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

/// OpenImageIO's messages span lines and repeat the file's name.
std::string one_line(std::string text, const fs::path& file) {
  for (const std::string& name : {" (\"" + file.string() + "\")", " for \"" + file.string() + "\""})
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) text.erase(at, name.size());
  while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n')) text.replace(at, 1, "; ");
  return text.empty() ? "unknown error" : text;
}

/// Locked while OpenImageIO opens a file. Up to version 2.4.7 it decodes the headers of TIFFs with static tables that
/// opening a file adds to (its issue 3756, its pull request 3767). Pixels are decoded without the lock.
std::mutex& opening() {
  static std::mutex mutex;
  return mutex;
}

std::unique_ptr<OIIO::ImageInput> open(const fs::path& file, std::string& wrong) {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;  // or colours come multiplied by the alpha that is dropped
  config["raw:user_flip"] = 0;           // or raw photos come turned by their orientation tag
  const std::lock_guard lock(opening());
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(file.string(), &config);
  if (!input) wrong = one_line(OIIO::geterror(), file);
  // The codec uses one thread: photos are decoded in parallel, inside tasks.
  if (input) input->threads(1);
  return input;
}

/// Samples of EXR and HDR files are light by definition, but where an HDR states the curve that it has applied to them. Of
/// other formats the colour space's name tells: "Linear", and from version 3.0 of OpenImageIO on "lin_rec709" and the like.
bool holds_linear_light(const OIIO::ImageSpec& spec, std::string_view format) {
  if (!spec.format.is_floating_point()) return false;
  if (format == "openexr" || format == "hdr") return spec.get_float_attribute("oiio:Gamma", 1) == 1;
  std::string space(spec.get_string_attribute("oiio:ColorSpace"));
  std::ranges::transform(space, space.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return space == "linear" || space == "scene_linear" || space.starts_with("lin_");
}

std::optional<SampleType> stored_type(const OIIO::TypeDesc& format) {
  if (format.is_floating_point()) return SampleType::f32;
  if (format.basetype == OIIO::TypeDesc::UINT8) return SampleType::u8;
  return format.basetype == OIIO::TypeDesc::UINT16 ? std::optional(SampleType::u16) : std::nullopt;
}

/// The names that an EXR's channels have; of other formats they are made up.
std::vector<Band> named_channels(const OIIO::ImageSpec& spec) {
  std::vector<Band> bands;
  for (const std::string& name : spec.channelnames) bands.push_back({name});
  return bands;
}

OtherHeader header_of(const OIIO::ImageInput& input) {
  const OIIO::ImageSpec& spec = input.spec();
  OtherHeader header;
  header.format = input.format_name();
  header.width = spec.width;
  header.height = spec.height;
  header.depth = spec.depth;
  // The fourth byte of a BMP's pixels is reserved, and 0 in most files.
  header.channels = header.format == "bmp" ? std::min(spec.nchannels, 3) : spec.nchannels;
  header.bits = spec.format.is_floating_point() ? 0 : static_cast<int>(8 * spec.format.basesize());
  header.alpha_channel = header.format == "bmp" ? -1 : spec.alpha_channel;
  header.linear_light = holds_linear_light(spec, header.format);
  header.type = stored_type(spec.format);
  header.type_name = spec.format.c_str();
  if (header.format == "openexr") header.bands = named_channels(spec);
  // An EXR's data window; the picture is its display window.
  header.whole = header.format != "openexr" || (spec.width == spec.full_width && spec.height == spec.full_height &&
                                                spec.x == spec.full_x && spec.y == spec.full_y);
  // A raw photo is also a TIFF, with one sample a pixel behind a colour filter array, or linear: TIFF/EP and DNG.
  constexpr int kFilterArray = 32803, kLinearRaw = 34892;
  const int meaning = spec.get_int_attribute("tiff:PhotometricInterpretation");
  header.raw = meaning == kFilterArray || meaning == kLinearRaw;
  header.exposure_seconds = static_cast<double>(spec.get_float_attribute("ExposureTime"));
  header.f_number = static_cast<double>(spec.get_float_attribute("FNumber"));
  header.sensitivity = spec.get_int_attribute("Exif:PhotographicSensitivity");
  const OIIO::ParamValue* profile = spec.find_attribute("ICCProfile");
  if (profile != nullptr && profile->type().basetype == OIIO::TypeDesc::UINT8) {
    const auto* bytes = static_cast<const std::uint8_t*>(profile->data());
    header.profile.assign(bytes, bytes + profile->datasize());
  }
  return header;
}

OIIO::TypeDesc type_in(const SampleRoom& room, const OIIO::ImageSpec& spec) {
  if (room.form == SampleForm::bytes) return OIIO::TypeDesc::UINT8;
  return room.form == SampleForm::reals || spec.format.is_floating_point() ? OIIO::TypeDesc(OIIO::TypeDesc::FLOAT)
                                                                           : spec.format;
}

/// Reads rows of the first channels straight into the room where the file holds them like that, else a few at a time: for
/// the whole picture, OpenImageIO would decode up to 64 MB into a buffer of its own and copy them from there.
bool read_rows(OIIO::ImageInput& input, const SampleRoom& room) {
  constexpr int kRows = 64;
  const OIIO::ImageSpec& spec = input.spec();
  const OIIO::TypeDesc type = type_in(room, spec);
  if (spec.tile_width > 0) return input.read_image(0, 0, 0, room.channels, type, room.samples);
  const std::size_t row = type.size() * static_cast<std::size_t>(room.channels) * static_cast<std::size_t>(spec.width);
  auto* to = static_cast<std::byte*>(room.samples);
  if (type == spec.format && room.channels == spec.nchannels && spec.channelformats.empty())
    return input.read_native_scanlines(0, 0, spec.y, spec.y + spec.height, 0, to);
  for (int y = 0; y < spec.height; y += kRows) {
    const int end = std::min(y + kRows, spec.height);
    if (!input.read_scanlines(0, 0, spec.y + y, spec.y + end, 0, 0, room.channels, type, to)) return false;
    to += row * static_cast<std::size_t>(end - y);
  }
  return true;
}

std::string read_header(const fs::path& file, OtherHeader& header) try {
  std::string wrong;
  if (const auto input = open(file, wrong)) header = header_of(*input);
  return wrong;
} catch (const std::exception& error) {
  return one_line(error.what(), file);
}

std::string decode(const fs::path& file, const SampleRoom& room) try {
  std::string wrong;
  const auto input = open(file, wrong);
  if (!input) return wrong;
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width != room.width || spec.height != room.height || spec.nchannels < room.channels)
    return "it changes while it is read";
  const bool good = read_rows(*input, room);
  const std::string message = input->geterror();
  return good && message.empty() ? "" : one_line(message, file);
} catch (const std::exception& error) {
  return one_line(error.what(), file);
}

}  // namespace
}  // namespace gpvc::io

const gpvc::io::OtherFormats* gpvc_other_formats() {
  static constexpr gpvc::io::OtherFormats kFormats{gpvc::io::read_header, gpvc::io::decode};
  return &kFormats;
}
