// Photos and pages through OpenImageIO.
#include "io/images/image_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <stdexcept>

#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/freed_memory.h"
#include "io/images/image_bounds.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

/// OpenImageIO's messages span lines and repeat the file's name; ours are one sentence.
std::string one_line(std::string text, const fs::path& file) {
  for (const std::string& name : {" (\"" + file.string() + "\")", " for \"" + file.string() + "\""})
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) text.erase(at, name.size());
  while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n')) text.replace(at, 1, "; ");
  return text.empty() ? "unknown error" : text;
}

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

/// Grey repeated, alpha and further channels dropped.
Image to_rgb(Image&& in) {
  if (in.channels == 3) return std::move(in);
  Image out = black_image(in.width, in.height, 3);
  const auto stride = static_cast<std::size_t>(in.channels);
  const std::size_t green = stride >= 3 ? 1 : 0, blue = stride >= 3 ? 2 : 0;
  for (std::size_t i = 0; 3 * i < out.pixels.size(); ++i) {
    out.pixels[3 * i] = in.pixels[stride * i];
    out.pixels[3 * i + 1] = in.pixels[stride * i + green];
    out.pixels[3 * i + 2] = in.pixels[stride * i + blue];
  }
  return out;
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

/// Decodes the first channels. Throws InputError unless the whole picture could be decoded.
void decode(const ImageBytes& image, OIIO::ImageInput& input, int channels, OIIO::TypeDesc type, void* pixels) {
  if (image.is_jpeg()) {
    input.geterror();  // of headers, which have been read
    decode_jpeg(image, {input.spec().width, input.spec().height, channels, static_cast<std::uint8_t*>(pixels)});
    return;
  }
  const bool good = read_rows(input, channels, type, pixels);
  const std::string message = input.geterror();
  if (!good || !message.empty())
    throw InputError(image.file, image.part, "cannot be decoded whole: " + one_line(message, image.file));
}

/// True for formats of linear light, EXR and HDR.
bool holds_linear_light(const OIIO::ImageSpec& spec) {
  const std::string space = lower_case(std::string(spec.get_string_attribute("oiio:ColorSpace")));
  return spec.format.is_floating_point() && (space == "linear" || space == "scene_linear");
}

/// sRGB's curve, IEC 61966-2-1. Values above white become white, NaN becomes black.
std::uint8_t srgb_from_linear(float light) {
  if (!(light > 0)) return 0;
  if (light >= 1) return 255;
  const float value = light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(255 * value + 0.5f);
}

Image decode_rgb(const ImageBytes& bytes, OIIO::ImageInput& input, std::vector<std::uint8_t> storage = {}) {
  // The codec uses one thread: photos are decoded in parallel, inside tasks.
  input.threads(1);
  const OIIO::ImageSpec& spec = input.spec();
  Image image{spec.width, spec.height, std::min(spec.nchannels, 4), std::move(storage)};
  const std::size_t size = pixel_index(0, spec.height, spec.width) * static_cast<std::size_t>(image.channels);
  if (image.pixels.capacity() < size || image.pixels.capacity() > size + size / 8) free_memory(image.pixels);
  image.pixels.resize(size);
  if (holds_linear_light(spec)) {
    std::vector<float> light(image.pixels.size());
    decode(bytes, input, image.channels, OIIO::TypeDesc::FLOAT, light.data());
    std::transform(light.begin(), light.end(), image.pixels.begin(), srgb_from_linear);
  } else {
    decode(bytes, input, image.channels, OIIO::TypeDesc::UINT8, image.pixels.data());
  }
  return to_rgb(std::move(image));
}

/// Excludes by the pixels' alphas alone, or as mask_pixels() does.
enum class Excludes { transparent, dark };

template <typename Sample>
MaskPixels excluded_samples(const ImageBytes& bytes, OIIO::ImageInput& input, Excludes what, OIIO::TypeDesc type,
                            Sample white) {
  const OIIO::ImageSpec& spec = input.spec();
  const auto channels = static_cast<std::size_t>(spec.nchannels), width = static_cast<std::size_t>(spec.width);
  std::vector<Sample> samples(width * static_cast<std::size_t>(spec.height) * channels);
  decode(bytes, input, spec.nchannels, type, samples.data());
  const std::size_t pixels = samples.size() / channels;
  const auto alpha_channel = static_cast<std::size_t>(spec.alpha_channel);  // past all channels if there is none
  for (std::size_t i = 0; i < pixels; ++i) {
    const Sample* pixel = samples.data() + i * channels;
    Sample value = what == Excludes::dark ? Sample{0} : white;
    for (std::size_t c = 0; c < channels && what == Excludes::dark; ++c)
      if (c != alpha_channel) value = std::max(value, pixel[c]);
    samples[i] = alpha_channel < channels ? std::min(value, pixel[alpha_channel]) : value;
  }
  samples.resize(pixels);
  const auto half = static_cast<Sample>(white / 2);
  const bool soft = what == Excludes::dark &&
                    (bytes.is_jpeg() || std::ranges::any_of(samples, [&](Sample value) { return value > half; }));
  MaskPixels mask{empty_exclusion(spec.width, spec.height)};
  std::size_t grey = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (soft ? !(samples[i] > half) : samples[i] == Sample{0}) exclude(mask.excluded, i % width, i / width);
    grey += soft && samples[i] > Sample{0} && samples[i] < white ? 1 : 0;
  }
  mask.grey_share = static_cast<double>(grey) / static_cast<double>(pixels);
  return mask;
}

MaskPixels excluded_pixels(const fs::path& file, Excludes what) {
  const std::unique_ptr<OIIO::ImageInput> input = open_image(file);
  const FileBytes bytes(file);
  const ImageBytes image{file, "", bytes.view()};
  check_jpeg(image);
  input->threads(1);
  if (what == Excludes::transparent && input->spec().alpha_channel < 0)
    throw InputError(file, "", "has lost its alpha channel");
  // Samples are compared at the file's own depth: where 0 alone is black, it is an exact one.
  return input->spec().format == OIIO::TypeDesc::UINT8
             ? excluded_samples<std::uint8_t>(image, *input, what, OIIO::TypeDesc::UINT8, 255)
             : excluded_samples<float>(image, *input, what, OIIO::TypeDesc::FLOAT, 1);
}

/// Means of 2 x 2 pixels of 3 channels, in a loop that a compiler makes vectors of.
void halve_rows(const std::uint8_t* upper, const std::uint8_t* lower, int width, std::uint8_t* to) {
  for (int x = 0; x < width; ++x, upper += 6, lower += 6, to += 3)
    for (int c = 0; c < 3; ++c)
      to[c] = static_cast<std::uint8_t>((upper[c] + upper[c + 3] + lower[c] + lower[c + 3] + 2) / 4);
}

void write_jpeg(OutputFile& out, const fs::path& file, const Image& image, int quality, const ColorProfile& profile) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
  spec["Compression"] = "jpeg:" + std::to_string(std::clamp(quality, 1, 100));
  spec["jpeg:subsampling"] = "4:4:4";
  if (!profile.empty())
    spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(profile.size())),
                   profile.data());
  OIIO::Filesystem::IOVecOutput proxy;  // and from there to `out`, so that a full disk is noticed
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("jpeg");
  if (!output) throw OutputError(file, "cannot be encoded: " + one_line(OIIO::geterror(), file));
  output->threads(1);
  const bool good = output->set_ioproxy(&proxy) && output->open(file.string(), spec) &&
                    output->write_image(OIIO::TypeDesc::UINT8, image.pixels.data());
  const bool closed = output->close();
  if (!good || !closed) throw OutputError(file, "cannot be encoded: " + one_line(output->geterror(), file));
  out.write(proxy.buffer().data(), proxy.size());
}

}  // namespace

ImageSize read_image_size(const fs::path& file) {
  const std::unique_ptr<OIIO::ImageInput> input = open_image(file);
  return {input->spec().width, input->spec().height};
}

void check_photo_end(const fs::path& file) {
  const FileBytes bytes(file, FileBytes::Use::in_places);
  const std::string_view view = bytes.view();
  check_png({file, "", view});
  // Cameras append previews and data of their own. A marker of a preview there may pass for the photo's; then decoding
  // finds what is missing.
  constexpr std::size_t kTail = 1 << 16;
  const std::string_view tail = view.substr(view.size() - std::min(view.size(), kTail));
  if (tail.find("\xFF\xD9") == std::string_view::npos) check_jpeg({file, "", view});
}

int sample_bits(const fs::path& file) {
  const OIIO::TypeDesc type = open_image(file)->spec().format;
  return type.is_floating_point() ? 0 : static_cast<int>(8 * type.basesize());
}

bool has_alpha(const fs::path& file) {
  const std::unique_ptr<OIIO::ImageInput> input = open_image(file);
  // The fourth byte of a BMP's pixels is reserved, and 0 in most files.
  return input->spec().alpha_channel >= 0 && std::string_view(input->format_name()) != "bmp";
}

PhotoExclusion transparent_pixels(const fs::path& file) {
  return excluded_pixels(file, Excludes::transparent).excluded;
}

MaskPixels mask_pixels(const fs::path& file) { return excluded_pixels(file, Excludes::dark); }

Image read_image(const fs::path& file) { return read_image(file, {}); }

Image read_image(const fs::path& file, std::vector<std::uint8_t> storage) {
  const std::unique_ptr<OIIO::ImageInput> input = open_image(file);
  const FileBytes bytes(file);
  const ImageBytes image{file, "", bytes.view()};
  check_jpeg(image);
  return decode_rgb(image, *input, std::move(storage));
}

Image decode_image(const fs::path& file, const std::string& part, std::string_view bytes) {
  const ImageBytes image{file, part, bytes};
  const char* format = check_headers(image);
  if (format == nullptr) throw InputError(file, part, "expected a PNG or a JPEG");
  check_jpeg(image);
  OIIO::Filesystem::IOMemReader reader(const_cast<char*>(bytes.data()), bytes.size());
  std::unique_lock lock(opening());
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
  if (!input) throw InputError(file, part, "cannot be decoded: " + one_line(OIIO::geterror(), file));
  OIIO::ImageSpec spec;
  if (!input->set_ioproxy(&reader) || !input->open(part, spec, reader_options()))
    throw InputError(file, part, "is no image that can be read: " + one_line(input->geterror(), file));
  lock.unlock();
  check_claims(file, part, *input, bytes.size());
  return decode_rgb(image, *input);
}

ColorProfile read_color_profile(const fs::path& file) {
  const std::unique_ptr<OIIO::ImageInput> input = open_image(file);
  const OIIO::ParamValue* found = input->spec().find_attribute("ICCProfile");
  if (!found || found->type().basetype != OIIO::TypeDesc::UINT8) return {};
  const auto* bytes = static_cast<const std::uint8_t*>(found->data());
  ColorProfile profile(bytes, bytes + found->datasize());
  // ICC.1: a header of 128 bytes with the size at 0, the data's colour space at 16, the signature at 36.
  constexpr std::size_t kHeader = 128, kSpace = 16, kSignature = 36;
  const auto reads = [&](std::size_t at, std::string_view word) {
    return std::equal(word.begin(), word.end(), profile.begin() + static_cast<std::ptrdiff_t>(at));
  };
  if (profile.size() < kHeader || !reads(kSpace, "RGB ") || !reads(kSignature, "acsp")) return {};
  return profile;
}

Image reduce_image(const Image& image, int factor) {
  if (factor == 1) return image;
  Image out = black_image(image.width / factor, image.height / factor, image.channels);
  if (factor == 2 && image.channels == 3) {
    for (int y = 0; y < out.height; ++y)
      halve_rows(image.at(0, 2 * y), image.at(0, 2 * y + 1), out.width, out.at(0, y));
    return out;
  }
  const auto channels = static_cast<std::size_t>(image.channels);
  const std::size_t row = static_cast<std::size_t>(out.width) * channels;
  const std::uint64_t area = static_cast<std::uint64_t>(factor) * static_cast<std::uint64_t>(factor);
  std::vector<std::uint64_t> sums(row);
  for (int y = 0; y < out.height; ++y) {
    std::fill(sums.begin(), sums.end(), 0);
    for (int sub_y = 0; sub_y < factor; ++sub_y) {
      const std::uint8_t* in = image.at(0, y * factor + sub_y);
      for (std::size_t x = 0; x < row; x += channels)
        for (int sub_x = 0; sub_x < factor; ++sub_x)
          for (std::size_t c = 0; c < channels; ++c) sums[x + c] += *in++;
    }
    std::uint8_t* to = out.at(0, y);
    for (std::size_t x = 0; x < row; ++x) to[x] = static_cast<std::uint8_t>((sums[x] + area / 2) / area);
  }
  return out;
}

void write_image(const fs::path& file, const Image& image, ImageFormat format, int quality,
                 const ColorProfile& profile) {
  if (image.width < 1 || image.height < 1 || image.channels < 1 || image.channels > 4 ||
      image.pixels.size() != static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                                 static_cast<std::size_t>(image.channels))
    throw std::invalid_argument("write_image: the pixels do not fit the size");
  OutputFile out(file);
  if (format == ImageFormat::png)
    write_png(out, image, profile);
  else
    write_jpeg(out, file, image, quality, profile);
  out.commit();
}

}  // namespace gpvc::io
