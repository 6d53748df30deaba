#include "io/images/codec.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <mutex>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/files/paths.h"

namespace gpvc::io {

namespace fs = std::filesystem;

std::string one_line(std::string text, const fs::path& file) {
  for (const std::string& name : {" (\"" + file.string() + "\")", " for \"" + file.string() + "\""})
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) text.erase(at, name.size());
  while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n')) text.replace(at, 1, "; ");
  return text.empty() ? "unknown error" : text;
}

namespace {

/// The formats accepted for photos, masks and pages. OpenImageIO alone would try all of its formats on a file, and some
/// of them, above all Targa, accept any bytes and believe the size that they find there.
struct Codec {
  std::string_view name;
  std::int64_t most_from_byte;  ///< samples that a byte can hold; 0: see check_png, check_jpeg
};
// Deflate and simpler codings make at most 1032 bytes from one, each of 8 one-bit samples; the densest block of zstd
// makes 128 KiB from four bytes; fax coding spends one bit on a white row.
constexpr std::int64_t kPlain = 8 * 1032, kDense = 1 << 20;
constexpr Codec kCodecs[] = {{"jpeg", 0},     {"png", 0},       {"tiff", kDense}, {"openexr", kDense},
                             {"raw", kDense}, {"webp", kDense}, {"heif", kDense}, {"jpeg2000", kDense},
                             {"bmp", kPlain}, {"hdr", kPlain},  {"pnm", kPlain},  {"psd", kPlain},
                             {"dpx", kPlain}};

/// Refuses a size that the file cannot hold before memory is allocated for it.
void check_claims(const fs::path& file, const std::string& part, const OIIO::ImageInput& input, std::uintmax_t bytes) {
  const OIIO::ImageSpec& spec = input.spec();
  const std::string_view format = input.format_name();
  const auto* codec =
      std::find_if(std::begin(kCodecs), std::end(kCodecs), [&](const Codec& known) { return known.name == format; });
  if (codec == std::end(kCodecs))
    throw InputError(file, part,
                     "is no image that can be read, at most a " + std::string(format) +
                         " by chance; expected JPEG, PNG, TIFF, EXR or the like");
  check_size(file, part, spec.width, spec.height, spec.nchannels);
  if (spec.depth > 1) throw InputError(file, part, "is a volume, expected an image");
  const std::int64_t samples = std::int64_t{spec.width} * spec.height * spec.nchannels;
  if (codec->most_from_byte > 0 && static_cast<std::uintmax_t>(samples / codec->most_from_byte) > bytes)
    refuse_claim(file, part, spec.width, spec.height, bytes);
}

OIIO::ImageSpec reader_options() {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;  // or colours come multiplied by the alpha that is dropped
  config["raw:user_flip"] = 0;           // or raw photos come turned by their orientation tag
  return config;
}

/// Locked while OpenImageIO opens a file. Up to version 2.4.7 it decodes the headers of JPEGs (ICC profiles) and TIFFs
/// with static tables that opening a file adds to (its issue 3756, its pull request 3767). Pixels are decoded without
/// the lock.
std::mutex& opening() {
  static std::mutex mutex;
  return mutex;
}

/// Checks what must hold before OpenImageIO sees the image. Returns the format by content for those of most photos and
/// masks, null for all others. OpenImageIO would try the format of the name's extension first and then all others, which
/// occasionally fails when several threads do so at once.
const char* check_headers(const ImageBytes& image) {
  check_png(image);
  check_jpeg_metadata(image);
  return image.is_jpeg() ? "jpeg" : image.view.starts_with("\x89PNG\r\n\x1A\n") ? "png" : nullptr;
}

/// Reads rows of the first channels straight into `pixels` where the file holds them like that, else a few at a time: for
/// the whole picture, OpenImageIO would decode up to 64 MB into a buffer of its own and copy them from there.
bool read_rows(OIIO::ImageInput& input, int channels, OIIO::TypeDesc type, void* pixels) {
  constexpr int kRows = 64;
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.tile_width > 0) return input.read_image(0, 0, 0, channels, type, pixels);
  const std::size_t row = type.size() * static_cast<std::size_t>(channels) * static_cast<std::size_t>(spec.width);
  auto* to = static_cast<std::byte*>(pixels);
  if (type == spec.format && channels == spec.nchannels && spec.channelformats.empty())
    return input.read_native_scanlines(0, 0, spec.y, spec.y + spec.height, 0, to);
  for (int y = 0; y < spec.height; y += kRows) {
    const int end = std::min(y + kRows, spec.height);
    if (!input.read_scanlines(0, 0, spec.y + y, spec.y + end, 0, 0, channels, type, to)) return false;
    to += row * static_cast<std::size_t>(end - y);
  }
  return true;
}

}  // namespace

std::unique_ptr<OIIO::ImageInput> open_image(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw InputError(file, "", "does not exist");
  if (is_folder(file)) throw InputError(file, "", "is a folder, expected an image");
  // The headers of all photos of a scene are read before the first is decoded: only the pages needed are read.
  const FileBytes bytes(file, FileBytes::Use::in_places);
  if (bytes.view().empty()) throw InputError(file, "", "is empty, expected an image");
  const char* format = check_headers({file, "", bytes.view()});
  // OpenImageIO believes the size that a GIF claims as soon as it opens it.
  if (bytes.view().starts_with("GIF8"))
    throw InputError(file, "", "is a GIF, expected JPEG, PNG, TIFF, EXR or the like");
  const OIIO::ImageSpec config = reader_options();
  std::unique_lock lock(opening());
  std::unique_ptr<OIIO::ImageInput> input;
  if (format) {
    input = OIIO::ImageInput::create(format);
    OIIO::ImageSpec spec;
    if (input && !input->open(file.string(), spec, config))
      throw InputError(file, "", "is no image that can be read: " + one_line(input->geterror(), file));
  } else {
    input = OIIO::ImageInput::open(file.string(), &config);
  }
  if (!input) throw InputError(file, "", "is no image that can be read: " + one_line(OIIO::geterror(), file));
  lock.unlock();
  check_claims(file, "", *input, bytes.view().size());
  const OIIO::ImageSpec& opened = input->spec();
  if (std::string_view(input->format_name()) == "openexr" &&
      (opened.width != opened.full_width || opened.height != opened.full_height || opened.x != opened.full_x ||
       opened.y != opened.full_y))
    throw InputError(file, "", "its data window is not its display window, expected the whole picture and no more");
  // A raw photo is also a TIFF, with one sample a pixel behind a colour filter array, or linear: TIFF/EP and DNG.
  constexpr int kFilterArray = 32803, kLinearRaw = 34892;
  const int meaning = input->spec().get_int_attribute("tiff:PhotometricInterpretation");
  if (meaning == kFilterArray || meaning == kLinearRaw)
    throw InputError(file, "",
                     "is a camera's raw photo, which OpenImageIO reads only when it is built with LibRaw and the "
                     "name ends like .dng; expected that, or a JPEG, PNG or TIFF made of it");
  return input;
}

std::unique_ptr<OIIO::ImageInput> open_image(const ImageBytes& image, OIIO::Filesystem::IOMemReader& reader) {
  const auto& [file, part, bytes] = image;
  const char* format = check_headers(image);
  if (format == nullptr) throw InputError(file, part, "expected a PNG or a JPEG");
  check_jpeg(image);
  std::unique_lock lock(opening());
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
  if (!input) throw InputError(file, part, "cannot be decoded: " + one_line(OIIO::geterror(), file));
  OIIO::ImageSpec spec;
  if (!input->set_ioproxy(&reader) || !input->open(part, spec, reader_options()))
    throw InputError(file, part, "is no image that can be read: " + one_line(input->geterror(), file));
  lock.unlock();
  check_claims(file, part, *input, bytes.size());
  return input;
}

void decode_samples(const ImageBytes& image, OIIO::ImageInput& input, int channels, OIIO::TypeDesc type, void* pixels) {
  if (image.is_jpeg()) {
    input.geterror();  // of headers, which have been read
    decode_jpeg(image, {input.spec().width, input.spec().height, channels, static_cast<std::uint8_t*>(pixels)});
    return;
  }
  if (std::string_view(input.format_name()) == "tiff") check_tiff(image);
  const bool good = read_rows(input, channels, type, pixels);
  const std::string message = input.geterror();
  if (!good || !message.empty())
    throw InputError(image.file, image.part, "cannot be decoded whole: " + one_line(message, image.file));
}

}  // namespace gpvc::io
