#include "io/images/image_file.h"

#include <algorithm>
#include <cmath>

#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/freed_memory.h"
#include "io/images/codec.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

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

/// sRGB's curve, IEC 61966-2-1. Values above white become white, NaN becomes black.
std::uint8_t srgb_from_linear(float light) {
  if (!(light > 0)) return 0;
  if (light >= 1) return 255;
  const float value = light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(255 * value + 0.5f);
}

Image decode_rgb(const ImageBytes& bytes, std::vector<std::uint8_t> storage = {}) {
  const ImageHeader header = read_header(bytes);
  Image image{header.width, header.height, std::min(header.channels, 4), std::move(storage)};
  const std::size_t size = pixel_index(0, header.height, header.width) * static_cast<std::size_t>(image.channels);
  if (image.pixels.capacity() < size || image.pixels.capacity() > size + size / 8) free_memory(image.pixels);
  image.pixels.resize(size);
  if (header.linear_light) {
    std::vector<float> light(image.pixels.size());
    decode_samples(bytes, header, image.channels, light.data());
    std::transform(light.begin(), light.end(), image.pixels.begin(), srgb_from_linear);
  } else {
    decode_samples(bytes, header, image.channels, image.pixels.data());
  }
  return to_rgb(std::move(image));
}

/// Means of 2 x 2 pixels of 3 channels, in a loop that a compiler makes vectors of.
void halve_rows(const std::uint8_t* upper, const std::uint8_t* lower, int width, std::uint8_t* to) {
  for (int x = 0; x < width; ++x, upper += 6, lower += 6, to += 3)
    for (int c = 0; c < 3; ++c)
      to[c] = static_cast<std::uint8_t>((upper[c] + upper[c + 3] + lower[c] + lower[c + 3] + 2) / 4);
}

}  // namespace

FileBytes image_bytes(const fs::path& file, FileBytes::Use use) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw InputError(file, "", "does not exist");
  if (is_folder(file)) throw InputError(file, "", "is a folder, expected an image");
  return FileBytes(file, use);
}

namespace {

/// The headers of all photos of a scene are read before the first is decoded: only the pages needed are read.
ImageHeader header_of(const fs::path& file) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::in_places);
  return read_header({file, "", bytes.view()});
}

}  // namespace

ImageSize read_image_size(const fs::path& file) {
  const ImageHeader header = header_of(file);
  return {header.width, header.height};
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

int sample_bits(const fs::path& file) { return header_of(file).bits; }

bool has_alpha(const fs::path& file) { return header_of(file).alpha_channel >= 0; }

Image read_image(const fs::path& file) { return read_image(file, {}); }

Image read_image(const fs::path& file, std::vector<std::uint8_t> storage) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::whole);
  return decode_rgb({file, "", bytes.view()}, std::move(storage));
}

Image decode_image(const fs::path& file, const std::string& part, std::string_view bytes) {
  return decode_rgb({file, part, bytes});
}

ColorProfile read_color_profile(const fs::path& file) {
  ColorProfile profile = header_of(file).profile;
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

}  // namespace gpvc::io
