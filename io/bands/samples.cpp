// Samples reduced, continued around, and looked at.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "io/bands/band_photo.h"
#include "io/lens/spherical.h"

namespace gpvc::io {

Image composite_of(const Samples& samples, const BandSet& bands, bool linear_light, const PixelRoom& room) {
  const auto black = static_cast<float>(bands.black), width = static_cast<float>(bands.white - bands.black);
  const auto level = [&](float value) {
    const float part = (value - black) / width;
    return linear_light ? srgb_from_linear(part) : static_cast<std::uint8_t>(std::clamp(part, 0.0f, 1.0f) * 255 + 0.5f);
  };
  std::vector<std::uint8_t> levels;  // of whole numbers
  if (samples.type != SampleType::f32)
    for (int value = 0; value < (samples.type == SampleType::u8 ? 256 : 65536); ++value)
      levels.push_back(level(static_cast<float>(value)));
  Image image = image_in(room, samples.width, samples.height, 3);
  const std::size_t size = bytes_of(samples.type), step = samples.pixel_bytes(), pixels = pixels_of(samples);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::byte* from = samples.bytes.data() + bands.composite[c] * size;
    std::uint8_t* to = image.pixels.data() + c;
    for (std::size_t i = 0; i < pixels; ++i, from += step, to += 3) {
      const float value = load_sample(from, samples.type);
      *to = levels.empty() ? level(value) : levels[static_cast<std::size_t>(value)];
    }
  }
  return image;
}

Image picture_of(const Samples& samples, const BandSet& bands) { return composite_of(samples, bands, false, new_room); }

Samples reduce_samples(const Samples& samples, int factor) {
  Samples out = zero_samples(samples.width / factor, samples.height / factor, samples.bands, samples.type);
  const std::size_t size = bytes_of(samples.type), bands = samples.bands;
  const double area = static_cast<double>(factor) * factor;
  std::vector<double> sums(static_cast<std::size_t>(out.width) * bands);
  std::byte* to = out.bytes.data();
  for (int y = 0; y < out.height; ++y) {
    std::ranges::fill(sums, 0.0);
    for (int row = y * factor; row < (y + 1) * factor; ++row) {
      const std::byte* from = samples.at(0, row);
      for (std::size_t block = 0; block < sums.size(); block += bands)
        for (int column = 0; column < factor; ++column)
          for (std::size_t band = 0; band < bands; ++band, from += size)
            sums[block + band] += static_cast<double>(load_sample(from, samples.type));
    }
    for (const double sum : sums) {
      store_sample(to, samples.type, static_cast<float>(sum / area));
      to += size;
    }
  }
  return out;
}

Samples continue_around(const Samples& panorama) {
  const int before = columns_before(panorama.width), behind = columns_behind(panorama.width);
  Samples out = zero_samples(before + panorama.width + behind, panorama.height, panorama.bands, panorama.type);
  std::byte* to = out.bytes.data();
  for (int y = 0; y < panorama.height; ++y)
    for (const auto& [first, count] :
         {std::pair(panorama.width - before, before), std::pair(0, panorama.width), std::pair(0, behind)})
      to = std::copy_n(panorama.at(first, y), static_cast<std::size_t>(count) * panorama.pixel_bytes(), to);
  return out;
}

}  // namespace gpvc::io
