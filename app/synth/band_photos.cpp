#include "app/synth/band_photos.h"

#include <algorithm>
#include <array>
#include <utility>

namespace gpvc::synth {
namespace {

struct KnownBand {
  const char* name;
  double wavelength_nm;
};
constexpr KnownBand kBlue{"Blue", 475}, kGreen{"Green", 560}, kRed{"Red", 668}, kEdge{"Red edge", 717},
    kInfrared{"NIR", 842};
constexpr KnownBand kTen[kMostBands] = {kBlue,
                                        kGreen,
                                        kRed,
                                        kInfrared,
                                        kEdge,
                                        {"Coastal blue", 444},
                                        {"Green 531", 531},
                                        {"Red 650", 650},
                                        {"Red edge 705", 705},
                                        {"Red edge 740", 740}};

std::vector<KnownBand> known_bands(std::size_t count) {
  switch (count) {
    case 1:
      return {kInfrared};
    case 2:
      return {kRed, kInfrared};
    case 3:
      return {kRed, kGreen, kBlue};
    case 4:
      return {kRed, kGreen, kBlue, kInfrared};
    default:
      return {kTen, kTen + count};
  }
}

bool is_colors(const BandOptions& options) { return options.count == 3; }

/// The photo of a band's lens, whose axis lies beside the first one's.
Camera moved(Camera camera, const BandShift& shift) {
  camera.cx += shift.right;
  camera.cy += shift.down;
  return camera;
}

}  // namespace

BandSet bands_of(const BandOptions& options) {
  BandSet set;
  set.type = options.type;
  for (const KnownBand& band : known_bands(options.count))
    if (is_colors(options))
      set.bands.push_back({band.name});
    else
      set.bands.push_back({band.name, band.wavelength_nm, "reflectance"});
  set.radiometric = !is_colors(options);
  return set;
}

BandShift shift_of(const BandOptions& options, std::size_t band) {
  constexpr BandShift kShifts[] = {{0, 0}, {1, -1}, {-2, 1}, {2, 1}, {-0.75, 1.5}};
  return options.apart ? kShifts[band % std::size(kShifts)] : BandShift{};
}

double sample_of_white(const BandOptions& options) {
  if (options.type == SampleType::f32) return 1;
  if (options.type == SampleType::u8) return is_colors(options) ? 255 : 200;
  return is_colors(options) ? 65535 : 32768;
}

Samples band_photo(SynthRenderer& renderer, const Camera& camera, const Pose& pose, const Shot& shot,
                   const SynthScene* unmodelled, const BandOptions& options, SynthPhoto& photo) {
  const std::vector<KnownBand> bands = known_bands(options.count);
  Samples samples{camera.width, camera.height, bands.size(), options.type, {}};
  samples.bytes.resize(pixel_index(0, camera.height, camera.width) * samples.pixel_bytes());
  const std::size_t together = options.apart ? 1 : 3, size = bytes_of(options.type);
  const auto white = static_cast<float>(sample_of_white(options));
  for (std::size_t first = 0; first < bands.size(); first += together) {
    Shot of_bands = shot;
    std::array<double, 3> wavelengths{};
    for (std::size_t i = 0; i < wavelengths.size(); ++i)
      wavelengths[i] = bands[std::min(first + i, bands.size() - 1)].wavelength_nm;
    of_bands.wavelengths_nm = wavelengths;
    SynthPhoto taken = renderer.photo(moved(camera, shift_of(options, first)), pose, of_bands, unmodelled);
    for (std::size_t i = 0; i < taken.light.size(); ++i)
      for (std::size_t c = 0; c < together && first + c < bands.size(); ++c)
        store_sample(samples.bytes.data() + i * samples.pixel_bytes() + (first + c) * size, options.type,
                     white * taken.light[i][c]);
    if (first == 0) photo = std::move(taken);
  }
  return samples;
}

}  // namespace gpvc::synth
