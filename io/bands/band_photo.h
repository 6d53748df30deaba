// Photos with all of their bands, as their files hold them.
#pragma once

#include <optional>
#include <span>

#include "io/images/image_file.h"
#include "io/photos.h"
#include "io/samples.h"
#include "io/scene.h"

namespace gpvc::io {

inline std::size_t pixels_of(const Samples& samples) { return pixel_index(0, samples.height, samples.width); }
/// All 0.
inline Samples zero_samples(int width, int height, std::size_t bands, SampleType type) {
  Samples samples{width, height, bands, type, {}};
  samples.bytes.resize(pixels_of(samples) * samples.pixel_bytes());
  return samples;
}

/// What a file holds beside an alpha.
struct StoredPhoto {
  Samples samples;  ///< 0 for what is no number
  /// Pixels that are no number in a band, or of the value that the file declares to stand for none; nullopt: there are none.
  std::optional<PhotoExclusion> without_data{};
  /// Where the alpha is 0, or the file's own mask excludes; nullopt: there is neither.
  std::optional<PhotoExclusion> transparent{};
  bool linear_light = false;
};

/// \param bands of a file with as many channels, what it calls an alpha is a band. Throws InputError, also for samples other than u8,
/// u16 and floats.
StoredPhoto read_stored(const std::filesystem::path& file, std::size_t bands = 0);

/// Of what a file calls an alpha: the share of the pixels above 0 that have the largest value, or nearly; 1 where all are 0. Tells
/// an alpha from a band: most visible pixels of an alpha have its largest value, whatever that is; a band's values vary. Throws InputError.
double opaque_share(const std::filesystem::path& file);

/// A view's photo before it is reduced, all bands of a pixel together.
struct BandPhoto {
  Samples samples;                            ///< of any value where pixels are excluded
  std::optional<PhotoExclusion> exclusion{};  ///< by mask, by alpha, and for want of data in a band
  bool linear_light = false;
};

/// Files other than the view's photo are laid over it as `places` say; what they do not show of it, or interpolate from pixels
/// without data, is excluded. So are pixels that are 0 in all bands of a view with a mask or an alpha. Throws InputError.
BandPhoto read_band_photo(const View& view, const BandSet& bands, std::span<const BandPlace> places);

/// What is looked at: 3 channels. Linear light gets sRGB's curve.
Image composite_of(const Samples& samples, const BandSet& bands, bool linear_light, const PixelRoom& room);

/// As of images, in io/images.h.
Samples reduce_samples(const Samples& samples, int factor);
Samples continue_around(const Samples& panorama);

}  // namespace gpvc::io
