// Photos of a synthetic scene in bands of their own wavelengths, as reflectance.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/synth/synth_scene.h"
#include "io/samples.h"

namespace gpvc::synth {

inline constexpr std::size_t kMostBands = 10;

struct BandShift {
  double right = 0, down = 0;  ///< px
};

/// How many bands, how they are stored, and where they lie.
struct BandOptions {
  std::size_t count = 0;  ///< 0: no bands, but JPEGs
  SampleType type = SampleType::u16;
  bool apart = false;  ///< each in a file of its own, whose lens lies a pixel or two aside
  bool any() const { return count > 0; }
};

/// Three bands are colours, others reflectance. One band is near infrared, two are red and near infrared, three red, green, blue, four these and near infrared, five and ten those of
/// cameras with as many lenses; other numbers the first of the ten. \pre 1 <= options.count <= kMostBands
BandSet bands_of(const BandOptions& options);

/// Where the band's photo shows what the first band's shows: by up to two pixels, the fifth by parts of them; none unless they are apart.
BandShift shift_of(const BandOptions& options, std::size_t band);

/// The sample of a surface that reflects all light, lit as a plane that faces it is: the most that the type holds for red, green and
/// blue alone; else, as reflectance, 200 of 8 bits, 32768 of 16. 1 of floats.
double sample_of_white(const BandOptions& options);

/// All bands of a photo, each at its place; samples are reflectance times light. The sky has the same in all bands.
/// \param photo of the first band, for what its pixels see
Samples band_photo(SynthRenderer& renderer, const Camera& camera, const Pose& pose, const Shot& shot,
                   const SynthScene* unmodelled, const BandOptions& options, SynthPhoto& photo);

}  // namespace gpvc::synth
