#include "atlas/sampling/layers.h"

#include "atlas/sampling/exposure.h"

namespace gpvc::atlas {

Color BandPainting::in_channels(std::size_t layer, const Color& picture, float neutral) const {
  const std::array<float, 3> channels{picture.r, picture.g, picture.b};
  std::array<float, 3> found{neutral, neutral, neutral};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t c = 3; c-- > 0;)
      if (bands->composite[c] == first_band(layer) + i) found[i] = channels[c];
  return {found[0], found[1], found[2]};
}

Color BandPainting::painted(std::size_t layer, const Color& sample, ViewId view, const PixelPoint& frame,
                            const Color& gain, const Color& added) const {
  if (bands->radiometric) return gains.empty() ? sample : gain_at(gains[layer - 1][index(view)], frame) * sample;
  const auto black = static_cast<float>(bands->black), unit = static_cast<float>(bands->units_per_level());
  const Color dark{black, black, black}, factor = in_channels(layer, gain, 1);
  const Color exposed = factor * ((1 / unit) * (sample - dark));
  return dark + unit * corrected(exposed, in_channels(layer, added, 0), factor);
}

Color BandPainting::in_bands(std::size_t layer, const Color& levels) const {
  const auto black = static_cast<float>(bands->black);
  return black * in_channels(layer, {1, 1, 1}, 0) + change_in_bands(layer, levels);
}

Color BandPainting::change_in_bands(std::size_t layer, const Color& levels) const {
  return static_cast<float>(bands->units_per_level()) * in_channels(layer, levels, 0);
}

}  // namespace gpvc::atlas
