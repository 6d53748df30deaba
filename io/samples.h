// Pictures of any depth and any number of bands: what is painted where photos are more than RGB of 8 bits.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "image.h"
#include "names.h"

namespace gpvc {

/// What a number of a raster is stored as: whole numbers from 0 on, of 8, 16 or 32 bits, or a float of 32.
enum class SampleType : std::uint8_t { u8, u16, u32, f32 };
inline constexpr Named<SampleType> kSampleTypeNames[] = {
    {"u8", SampleType::u8}, {"u16", SampleType::u16}, {"u32", SampleType::u32}, {"f32", SampleType::f32}};

constexpr std::size_t bytes_of(SampleType type) { return type == SampleType::u8 ? 1 : type == SampleType::u16 ? 2 : 4; }

/// What one band of a photo measures.
struct Band {
  std::string name;                       ///< unique among the bands of a set
  std::optional<double> wavelength_nm{};  ///< of the centre
  std::string unit{};                     ///< "reflectance", "K"; empty: unknown
  bool operator==(const Band&) const = default;
};

/// What all photos of a scene have in common. Their bands are those of one camera or registered to each other.
struct BandSet {
  SampleType type = SampleType::u16;  ///< u8, u16 or f32
  std::vector<Band> bands;            ///< at least one, in the order of the samples
  /// The bands that are red, green and blue in the pictures that the program looks at; all equal: grey.
  std::array<std::size_t, 3> composite{0, 1, 2};
  /// The samples that are 0 and 255 in these pictures: one range for all photos, all of their bands together. \pre black < white
  double black = 0, white = 65535;
  /// Quantities (reflectance, temperature) rather than colours, which are not to be mixed or levelled without being asked to.
  bool radiometric = false;
  bool operator==(const BandSet&) const = default;

  /// How much a sample changes with one grey level of the pictures.
  double units_per_level() const { return (white - black) / 255; }
  std::size_t pixel_bytes() const { return bands.size() * bytes_of(type); }
};

/// Row-major from the top-left, the bands of a pixel together, in the units of the file. Holds only numbers: no NaN, no infinity.
struct Samples {
  int width = 0, height = 0;
  std::size_t bands = 0;
  SampleType type = SampleType::u16;  ///< u8, u16 or f32
  std::vector<std::byte> bytes;       ///< width * height * bands samples in this machine's byte order

  std::size_t pixel_bytes() const { return bands * bytes_of(type); }
  const std::byte* at(int x, int y) const { return bytes.data() + pixel_index(x, y, width) * pixel_bytes(); }
  std::byte* at(int x, int y) { return const_cast<std::byte*>(static_cast<const Samples*>(this)->at(x, y)); }
};

/// The sample at some bytes, which need not be aligned. \pre u8, u16 or f32
inline float load_sample(const std::byte* from, SampleType type) {
  if (type == SampleType::u8) return static_cast<float>(std::to_integer<std::uint8_t>(*from));
  if (type == SampleType::u16) {
    std::uint16_t value = 0;
    std::memcpy(&value, from, sizeof value);
    return static_cast<float>(value);
  }
  float value = 0;
  std::memcpy(&value, from, sizeof value);
  return value;
}

/// Whole numbers are rounded to nearest and kept within the type's range; what is no number becomes 0 there. \pre u8, u16 or f32
inline void store_sample(std::byte* to, SampleType type, float value) {
  if (type == SampleType::f32) {
    std::memcpy(to, &value, sizeof value);
    return;
  }
  const float most = type == SampleType::u8 ? 255 : 65535;
  const auto whole = static_cast<std::uint16_t>(value >= most ? most : value > 0 ? value + 0.5f : 0);
  if (type == SampleType::u8)
    *to = static_cast<std::byte>(whole);
  else
    std::memcpy(to, &whole, sizeof whole);
}

}  // namespace gpvc
