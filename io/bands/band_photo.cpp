#include "io/bands/band_photo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "io/images/codec.h"
#include "io/images/mask_file.h"
#include "io/lens/spherical.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

std::size_t pixels_of(const Samples& samples) { return pixel_index(0, samples.height, samples.width); }

Samples samples_of(int width, int height, std::size_t bands, SampleType type) {
  Samples samples{width, height, bands, type, {}};
  samples.bytes.resize(pixels_of(samples) * samples.pixel_bytes());
  return samples;
}

void unite(std::optional<PhotoExclusion>& all, std::optional<PhotoExclusion> more) {
  if (!all) {
    all = std::move(more);
    return;
  }
  for (std::size_t i = 0; more && i < all->words.size(); ++i) all->words[i] |= more->words[i];
}

/// Calls `excludes` with the number of each pixel, and excludes those for which it returns true; nullopt: there are none.
template <typename Excludes>
std::optional<PhotoExclusion> excluded_where(int width, int height, const Excludes& excludes) {
  std::optional<PhotoExclusion> exclusion;
  std::size_t pixel = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x, ++pixel) {
      if (!excludes(pixel)) continue;
      if (!exclusion) exclusion = empty_exclusion(width, height);
      exclude(*exclusion, static_cast<std::size_t>(x), static_cast<std::size_t>(y));
    }
  return exclusion;
}

bool is_zero(const std::byte* from, std::size_t bytes) {
  return std::all_of(from, from + bytes, [](std::byte byte) { return byte == std::byte{0}; });
}

/// Takes the alpha out, and says where it is 0.
std::optional<PhotoExclusion> take_alpha(Samples& samples, std::size_t channel) {
  const std::size_t size = bytes_of(samples.type), pixel = samples.pixel_bytes(), before = channel * size,
                    after = pixel - before - size;
  const std::byte* from = samples.bytes.data();
  std::byte* to = samples.bytes.data();
  std::optional<PhotoExclusion> transparent = excluded_where(samples.width, samples.height, [&](std::size_t) {
    const bool is_transparent = load_sample(from + before, samples.type) == 0;
    std::memmove(to, from, before);
    std::memmove(to + before, from + before + size, after);
    from += pixel;
    to += pixel - size;
    return is_transparent;
  });
  --samples.bands;
  samples.bytes.resize(pixels_of(samples) * samples.pixel_bytes());
  if (!transparent) transparent = empty_exclusion(samples.width, samples.height);
  return transparent;
}

std::optional<PhotoExclusion> take_missing(Samples& samples, const std::optional<double>& nodata) {
  if (samples.type != SampleType::f32 && !nodata) return std::nullopt;
  const std::size_t size = bytes_of(samples.type);
  const auto missing = nodata ? static_cast<float>(*nodata) : std::nanf("");
  std::byte* sample = samples.bytes.data();
  return excluded_where(samples.width, samples.height, [&](std::size_t) {
    bool has_none = false;
    for (std::size_t band = 0; band < samples.bands; ++band, sample += size) {
      const float value = load_sample(sample, samples.type);
      if (std::isfinite(value) && value != missing) continue;
      has_none = true;
      store_sample(sample, samples.type, 0);
    }
    return has_none;
  });
}

/// Where a file of bands has a place of the photo, and what it shows there.
class Overlay {
 public:
  Overlay(const StoredPhoto& file, const BandPlace& place) : file_(file), m_(place.file_from_photo) {
    const auto whole = [](double value) { return value == std::floor(value); };
    is_shift_ = m_[0] == 1 && m_[1] == 0 && m_[3] == 0 && m_[4] == 1 && whole(m_[2]) && whole(m_[5]);
  }

  /// Writes all bands of the file at the photo's pixel (x, y). False: the file shows nothing there.
  bool put(int x, int y, std::byte* to) const {
    const Samples& from = file_.samples;
    const double px = m_[0] * (x + 0.5) + m_[1] * (y + 0.5) + m_[2], py = m_[3] * (x + 0.5) + m_[4] * (y + 0.5) + m_[5];
    if (!(px >= 0 && py >= 0 && px < from.width && py < from.height)) return false;
    if (is_shift_) {
      const int at_x = static_cast<int>(px), at_y = static_cast<int>(py);
      std::memcpy(to, from.at(at_x, at_y), from.pixel_bytes());
      return !is_missing(at_x, at_y);
    }
    return interpolate(px - 0.5, py - 0.5, to);
  }

 private:
  bool is_missing(int x, int y) const { return file_.without_data && file_.without_data->excludes(x, y); }

  /// Cubic convolution (Keys 1981, a = -1/2), within the values that it is made of: what overshoots them would be light that no
  /// pixel has, or less than none.
  bool interpolate(double x, double y, std::byte* to) const {
    const Samples& from = file_.samples;
    const double left = std::floor(x), top = std::floor(y);
    const std::array<float, 4> wx = weights(x - left), wy = weights(y - top);
    std::array<int, 4> columns{}, rows{};
    for (int i = 0; i < 4; ++i) {
      columns[static_cast<std::size_t>(i)] = std::clamp(static_cast<int>(left) - 1 + i, 0, from.width - 1);
      rows[static_cast<std::size_t>(i)] = std::clamp(static_cast<int>(top) - 1 + i, 0, from.height - 1);
    }
    if (file_.without_data)
      for (const int row : rows)
        for (const int column : columns)
          if (is_missing(column, row)) return false;
    const std::size_t size = bytes_of(from.type);
    for (std::size_t band = 0; band < from.bands; ++band) {
      float sum = 0, low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
      for (std::size_t j = 0; j < 4; ++j)
        for (std::size_t i = 0; i < 4; ++i) {
          const float value = load_sample(from.at(columns[i], rows[j]) + band * size, from.type);
          sum += wx[i] * wy[j] * value;
          low = std::min(low, value);
          high = std::max(high, value);
        }
      store_sample(to + band * size, from.type, std::clamp(sum, low, high));
    }
    return true;
  }

  static std::array<float, 4> weights(double t) {
    const double t2 = t * t, t3 = t2 * t;
    return {static_cast<float>(-0.5 * t + t2 - 0.5 * t3), static_cast<float>(1 - 2.5 * t2 + 1.5 * t3),
            static_cast<float>(0.5 * t + 2 * t2 - 1.5 * t3), static_cast<float>(-0.5 * t2 + 0.5 * t3)};
  }

  const StoredPhoto& file_;
  std::array<double, 6> m_;
  bool is_shift_ = false;
};

/// Bands of one file after those of others. \pre `all` has room for them
void lay_over(const StoredPhoto& file, const BandPlace& place, std::size_t first_band, BandPhoto& all) {
  const Overlay overlay(file, place);
  const std::size_t offset = first_band * bytes_of(all.samples.type);
  unite(all.exclusion, excluded_where(all.samples.width, all.samples.height, [&](std::size_t pixel) {
          const auto width = static_cast<std::size_t>(all.samples.width);
          const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
          return !overlay.put(x, y, all.samples.at(x, y) + offset);
        }));
}

/// Throws InputError for a file that does not hold what the scene's photos hold.
void check_samples(const fs::path& file, const Samples& samples, const View& view, const BandSet& bands,
                   std::size_t first_band) {
  if (samples.width / view.reduction != file_width(view.camera) ||
      samples.height / view.reduction != view.camera.height)
    throw InputError(
        file, "", "is " + size_text(samples.width, samples.height) + " pixels, which does not fit its camera any more");
  if (samples.type != bands.type || first_band + samples.bands > bands.bands.size())
    throw InputError(file, "", "does not hold the bands any more that it held when the scene was read");
}

BandPhoto read_files(const View& view, const BandSet& bands, std::span<const BandPlace> places,
                     std::optional<PhotoExclusion>& transparent) {
  BandPhoto all;
  std::size_t band = 0;
  for (std::size_t i = 0; i < view.band_files.size(); ++i) {
    StoredPhoto file = read_stored(view.band_files[i]);
    check_samples(view.band_files[i], file.samples, view, bands, band);
    if (i == 0) all.samples = samples_of(file.samples.width, file.samples.height, bands.bands.size(), bands.type);
    if (file.samples.width != all.samples.width || file.samples.height != all.samples.height)
      throw InputError(view.band_files[i], "",
                       "is " + size_text(file.samples.width, file.samples.height) + " pixels, " +
                           view.band_files[0].filename().string() + " is " +
                           size_text(all.samples.width, all.samples.height));
    lay_over(file, i < places.size() ? places[i] : BandPlace{}, band, all);
    band += file.samples.bands;
    if (view.band_files[i] == view.photo) transparent = std::move(file.transparent);
  }
  return all;
}

}  // namespace

StoredPhoto read_stored(const fs::path& file, std::size_t bands) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::whole);
  const ImageBytes image{file, "", bytes.view()};
  const ImageHeader header = read_header(image);
  refuse_other_types(image, header);
  check_jpeg(image);  // before there is room for what it claims
  StoredPhoto photo;
  photo.linear_light = header.linear_light;
  photo.samples = samples_of(header.width, header.height, static_cast<std::size_t>(header.channels), *header.type);
  decode_stored(image, header, photo.samples.bytes.data());
  if (header.alpha_channel >= 0 && photo.samples.bands != bands)
    photo.transparent = take_alpha(photo.samples, static_cast<std::size_t>(header.alpha_channel));
  photo.without_data = take_missing(photo.samples, header.nodata);
  return photo;
}

double partial_alpha(const fs::path& file) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::in_places);
  const ImageHeader header = read_header({file, "", bytes.view()});
  const Samples samples = read_stored(file, static_cast<std::size_t>(header.channels)).samples;
  const float full = samples.type == SampleType::u8 ? 255 : samples.type == SampleType::u16 ? 65535 : 1;
  const std::byte* alpha =
      samples.bytes.data() + static_cast<std::size_t>(header.alpha_channel) * bytes_of(samples.type);
  const std::size_t pixels = pixels_of(samples);
  std::size_t partial = 0;
  for (std::size_t i = 0; i < pixels; ++i, alpha += samples.pixel_bytes()) {
    const float value = load_sample(alpha, samples.type);
    partial += value != 0 && value != full ? 1 : 0;
  }
  return static_cast<double>(partial) / static_cast<double>(pixels);
}

Samples read_samples(const fs::path& file) { return read_stored(file).samples; }

BandPhoto read_band_photo(const View& view, const BandSet& bands, std::span<const BandPlace> places) {
  BandPhoto photo;
  std::optional<PhotoExclusion> transparent;
  if (view.band_files.empty()) {
    StoredPhoto file = read_stored(view.photo, bands.bands.size());
    check_samples(view.photo, file.samples, view, bands, bands.bands.size() - file.samples.bands);
    photo = {std::move(file.samples), std::move(file.without_data), file.linear_light};
    transparent = std::move(file.transparent);
  } else {
    photo = read_files(view, bands, places, transparent);
  }
  if (view.uses_alpha && !transparent) throw InputError(view.photo, "", "has lost its alpha channel");
  unite(photo.exclusion, read_whole_exclusion(view, std::move(transparent)));
  const Samples& samples = photo.samples;
  if (view.uses_alpha || !view.mask.empty())
    unite(photo.exclusion, excluded_where(samples.width, samples.height, [&](std::size_t pixel) {
            return is_zero(samples.bytes.data() + pixel * samples.pixel_bytes(), samples.pixel_bytes());
          }));
  return photo;
}

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
  Samples out = samples_of(samples.width / factor, samples.height / factor, samples.bands, samples.type);
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
  Samples out = samples_of(before + panorama.width + behind, panorama.height, panorama.bands, panorama.type);
  std::byte* to = out.bytes.data();
  for (int y = 0; y < panorama.height; ++y)
    for (const auto& [first, count] :
         {std::pair(panorama.width - before, before), std::pair(0, panorama.width), std::pair(0, behind)})
      to = std::copy_n(panorama.at(first, y), static_cast<std::size_t>(count) * panorama.pixel_bytes(), to);
  return out;
}

}  // namespace gpvc::io
