// Rasters in layers of three channels, by which photos are sampled and pages painted. The first layer is the picture of 8 bits; where
// photos have samples of their own (BandSet), the others are their bands, three at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/sampling/color.h"
#include "io/image.h"
#include "io/samples.h"

namespace gpvc::atlas {

/// Three channels of a raster, which it borrows.
template <typename Byte>
struct LayerOf {
  int width = 0, height = 0;
  Byte* first = nullptr;        ///< of the first pixel and channel
  std::size_t pixel_bytes = 3;  ///< from a pixel to the next
  std::size_t channels = 3;     ///< 1 to 3; those that are missing are 0, and not stored
  SampleType type = SampleType::u8;

  Color at(std::size_t pixel) const {
    const std::byte* from = first + pixel * pixel_bytes;
    const std::size_t size = bytes_of(type);
    Color color{load_sample(from, type), 0, 0};
    if (channels > 1) color.g = load_sample(from + size, type);
    if (channels > 2) color.b = load_sample(from + 2 * size, type);
    return color;
  }
  Color at(int x, int y) const { return at(pixel_index(x, y, width)); }

  void put(std::size_t pixel, const Color& color) const requires(!std::is_const_v<Byte>) {
    std::byte* to = first + pixel * pixel_bytes;
    const std::size_t size = bytes_of(type);
    store_sample(to, type, color.r);
    if (channels > 1) store_sample(to + size, type, color.g);
    if (channels > 2) store_sample(to + 2 * size, type, color.b);
  }
};
using Layer = LayerOf<const std::byte>;
using PageLayer = LayerOf<std::byte>;

inline std::size_t first_band(std::size_t layer) { return 3 * (layer - 1); }
inline std::size_t layers_of(const BandSet* bands) { return bands == nullptr ? 1 : 1 + (bands->bands.size() + 2) / 3; }

/// Of a photo or page with its samples, if it has any. \pre layer < layers_of(bands)
inline Layer layer_of(const Image& image, const Samples* samples, std::size_t layer) {
  if (layer == 0) return {image.width, image.height, reinterpret_cast<const std::byte*>(image.pixels.data())};
  const std::size_t band = first_band(layer);
  return {samples->width,
          samples->height,
          samples->bytes.data() + band * bytes_of(samples->type),
          samples->pixel_bytes(),
          std::min<std::size_t>(3, samples->bands - band),
          samples->type};
}

/// How a photo's bands become a page's.
struct BandPainting {
  const BandSet* bands = nullptr;  ///< null: pages have none
  /// Of quantities that are to be levelled, per layer after the first and per view; else empty.
  std::vector<std::vector<ViewExposure>> gains = {};

  std::size_t layers() const { return layers_of(bands); }
  /// True if bands are corrected and blended as the picture is. Quantities are not.
  bool are_colors() const { return bands != nullptr && !bands->radiometric; }
  /// True if what interpolation gives must stay between the samples that it lies among: quantities that are never negative
  /// would become so beside edges.
  bool are_limited() const { return bands->radiometric || bands->type == SampleType::f32; }

  /// What a page gets for a photo's samples in a layer after the first. `gain` and `added` are what corrected() takes for the
  /// picture; without effect on quantities.
  Color painted(std::size_t layer, const Color& sample, ViewId view, const PixelPoint& frame, const Color& gain,
                const Color& added) const;
  /// A colour of the picture, and a change of one, in grey levels: what they are in the bands of a layer. Other bands get 0.
  Color in_bands(std::size_t layer, const Color& levels) const;
  Color change_in_bands(std::size_t layer, const Color& levels) const;

 private:
  /// In a layer's channels what the picture's have where they are pictures of these bands, else `neutral`.
  Color in_channels(std::size_t layer, const Color& picture, float neutral) const;
};

}  // namespace gpvc::atlas
