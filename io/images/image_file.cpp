#include "io/images/image_file.h"

#include <algorithm>
#include <cmath>

#include "io/files/paths.h"
#include "io/images/codec.h"

namespace gpvc::io {

namespace {

/// Grey repeated, alpha and further channels dropped.
Image to_rgb(Image&& in, const PixelRoom& room) {
  if (in.channels == 3) return std::move(in);
  Image out = image_in(room, in.width, in.height, 3);
  const auto stride = static_cast<std::size_t>(in.channels);
  const std::size_t green = stride >= 3 ? 1 : 0, blue = stride >= 3 ? 2 : 0;
  for (std::size_t i = 0; 3 * i < out.pixels.size(); ++i) {
    out.pixels[3 * i] = in.pixels[stride * i];
    out.pixels[3 * i + 1] = in.pixels[stride * i + green];
    out.pixels[3 * i + 2] = in.pixels[stride * i + blue];
  }
  return out;
}

PhotoExclusion zeros_of_channel(const Image& image, int channel) {
  PhotoExclusion zeros = empty_exclusion(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (image.at(x, y)[channel] == 0) exclude(zeros, static_cast<std::size_t>(x), static_cast<std::size_t>(y));
  return zeros;
}

Image decode_rgb(const ImageBytes& bytes, const PixelRoom& room, PhotoExclusion* transparent = nullptr) {
  const ImageHeader header = read_header(bytes);
  check_jpeg(bytes);  // before there is room for what it claims
  Image image = image_in(room, header.width, header.height, std::min(header.channels, 4));
  if (header.linear_light) {
    std::vector<float> light(image.pixels.size());
    decode_samples(bytes, header, image.channels, light.data());
    std::transform(light.begin(), light.end(), image.pixels.begin(), srgb_from_linear);
  } else {
    decode_samples(bytes, header, image.channels, image.pixels.data());
  }
  if (transparent != nullptr) {
    // Deeper alphas that are nearly 0 have become 0 here, and alphas behind the fourth channel are not.
    const bool as_stored = header.bits == 8 && header.alpha_channel >= 0 && header.alpha_channel < image.channels;
    *transparent = as_stored ? zeros_of_channel(image, header.alpha_channel) : transparent_pixels(bytes.file);
    if (as_stored && header.has_mask) unite(*transparent, decode_mask(bytes, header));
  }
  return to_rgb(std::move(image), room);
}

}  // namespace

std::uint8_t srgb_from_linear(float light) {
  if (!(light > 0)) return 0;
  if (light >= 1) return 255;
  const float value = light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(255 * value + 0.5f);
}

// In a loop that a compiler makes vectors of.
void halve_rows(const std::uint8_t* upper, const std::uint8_t* lower, int width, std::uint8_t* to) {
  for (int x = 0; x < width; ++x, upper += 6, lower += 6, to += 3)
    for (int c = 0; c < 3; ++c)
      to[c] = static_cast<std::uint8_t>((upper[c] + upper[c + 3] + lower[c] + lower[c + 3] + 2) / 4);
}

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

PhotoHeader read_photo_header(const fs::path& file) {
  ImageHeader header = header_of(file);
  refuse_other_types({file, "", {}}, header);
  return {{header.width, header.height},
          header.exposure_value,
          *header.type,
          header.channels,
          header.alpha_channel,
          header.linear_light,
          header.colors,
          std::move(header.bands),
          header.has_mask};
}

std::optional<float> read_exposure_value(const fs::path& file) { return read_photo_header(file).exposure_value; }

bool is_grey(const fs::path& file) {
  const ImageHeader header = header_of(file);
  return header.channels - (header.alpha_channel >= 0 ? 1 : 0) == 1;
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

bool has_alpha(const fs::path& file) { return header_of(file).alpha_channel >= 0; }

bool hides_pixels(const fs::path& file) {
  const ImageHeader header = header_of(file);
  return header.alpha_channel >= 0 || header.has_mask;
}

Image read_image(const fs::path& file) { return read_image(file, new_room, nullptr); }

Image read_image(const fs::path& file, const PixelRoom& room, PhotoExclusion* transparent) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::whole);
  return decode_rgb({file, "", bytes.view()}, room, transparent);
}

Image decode_image(const fs::path& file, const std::string& part, std::string_view bytes) {
  return decode_rgb({file, part, bytes}, new_room);
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

Image reduce_image(const Image& image, int factor) { return reduce_image(image, factor, new_room); }

Image reduce_image(const Image& image, int factor, const PixelRoom& room) {
  if (factor == 1) return image;
  Image out = image_in(room, image.width / factor, image.height / factor, image.channels);
  if (factor == 2 && image.channels == 3) {
    for (int y = 0; y < out.height; ++y)
      halve_rows(image.at(0, 2 * y), image.at(0, 2 * y + 1), out.width, out.at(0, y));
    return out;
  }
  const auto channels = static_cast<std::size_t>(image.channels), edge = static_cast<std::size_t>(factor);
  const std::uint64_t area = edge * edge;
  std::vector<std::uint32_t> sums(static_cast<std::size_t>(out.width) * edge * channels);  // of columns of the blocks
  std::uint8_t* to = out.pixels.data();
  for (int y = 0; y < out.height; ++y) {
    std::ranges::fill(sums, 0u);
    for (int sub_y = 0; sub_y < factor; ++sub_y) {
      const std::uint8_t* in = image.at(0, y * factor + sub_y);
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += in[i];
    }
    for (std::size_t block = 0; block < sums.size(); block += edge * channels)
      for (std::size_t c = 0; c < channels; ++c) {
        std::uint64_t sum = area / 2;
        for (std::size_t i = c; i < edge * channels; i += channels) sum += sums[block + i];
        *to++ = static_cast<std::uint8_t>(sum / area);
      }
  }
  return out;
}

}  // namespace gpvc::io
