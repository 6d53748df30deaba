#include "io/bands/band_photo.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "io/bands/band_overlay.h"
#include "io/images/codec.h"
#include "io/images/mask_file.h"
#include "io/lens/spherical.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

void unite(std::optional<PhotoExclusion>& all, std::optional<PhotoExclusion> more) {
  if (!all)
    all = std::move(more);
  else if (more)
    unite(*all, *more);
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
  bool hides = false;
  for (std::size_t i = 0; i < view.band_files.size(); ++i) {
    StoredPhoto file = read_stored(view.band_files[i]);
    check_samples(view.band_files[i], file.samples, view, bands, band);
    if (i == 0) all.samples = zero_samples(file.samples.width, file.samples.height, bands.bands.size(), bands.type);
    if (file.samples.width != all.samples.width || file.samples.height != all.samples.height)
      throw InputError(view.band_files[i], "",
                       "is " + size_text(file.samples.width, file.samples.height) + " pixels, " +
                           view.band_files[0].filename().string() + " is " +
                           size_text(all.samples.width, all.samples.height));
    const bool is_photo = view.band_files[i] == view.photo;
    hides = hides || file.transparent;
    if (!is_photo && view.uses_alpha) unite(file.without_data, std::move(file.transparent));
    const BandCamera* camera = is_photo || view.band_cameras.empty() ? nullptr : &view.band_cameras[i];
    unite(all.exclusion, lay_over(file, i < places.size() ? places[i] : BandPlace{}, camera, band, all.samples));
    band += file.samples.bands;
    if (is_photo) transparent = std::move(file.transparent);
  }
  // Only other files than the photo say what they hide.
  if (hides && !transparent) transparent = empty_exclusion(all.samples.width, all.samples.height);
  return all;
}

}  // namespace

StoredPhoto read_stored(const fs::path& file, std::size_t bands) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::in_places);
  const ImageBytes image{file, "", bytes.view()};
  const ImageHeader header = read_header(image);
  refuse_other_types(image, header);
  check_jpeg(image);  // before there is room for what it claims
  StoredPhoto photo;
  photo.linear_light = header.linear_light;
  photo.samples = zero_samples(header.width, header.height, static_cast<std::size_t>(header.channels), *header.type);
  decode_stored(file, header, photo.samples.bytes.data());
  if (header.alpha_channel >= 0 && photo.samples.bands != bands)
    photo.transparent = take_alpha(photo.samples, static_cast<std::size_t>(header.alpha_channel));
  if (header.has_mask) unite(photo.transparent, decode_mask(image, header));
  photo.without_data = take_missing(photo.samples, header.nodata);
  return photo;
}

double opaque_share(const fs::path& file) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::in_places);
  const ImageHeader header = read_header({file, "", bytes.view()});
  const Samples samples = read_stored(file, static_cast<std::size_t>(header.channels)).samples;
  const std::byte* alpha =
      samples.bytes.data() + static_cast<std::size_t>(header.alpha_channel) * bytes_of(samples.type);
  const std::size_t pixels = pixels_of(samples);
  const auto value_of = [&](std::size_t i) { return load_sample(alpha + i * samples.pixel_bytes(), samples.type); };
  float most = 0;
  for (std::size_t i = 0; i < pixels; ++i) most = std::max(most, value_of(i));
  constexpr float kNearly = 0.95f;  // what JPEG makes of the largest
  std::size_t shown = 0, opaque = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const float value = value_of(i);
    shown += value > 0 ? 1 : 0;
    opaque += value > 0 && value >= kNearly * most ? 1 : 0;
  }
  return shown > 0 ? static_cast<double>(opaque) / static_cast<double>(shown) : 1;
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

}  // namespace gpvc::io
