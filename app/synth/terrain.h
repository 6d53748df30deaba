// Scenes of layers: hilly ground under floating sheets, and boards under slats.
#pragma once

#include "app/synth/synth_scene.h"

namespace gpvc::synth {

struct LayerOptions {
  std::size_t faces = 40000;  ///< aimed at
  double size_m = 4000;
  double gap_m = 20;  ///< terrain: of the sheets above the ground
  std::uint32_t seed = 1;
};

/// Two uneven layers, as in the paper's models A, B and C: hills, and sheets over about 0.4 of them that follow the hills'
/// facets `gap_m` higher, however small that is. Meant to be seen from afar: at the flight's height a float has steps of
/// a millimetre.
SynthScene make_terrain(const LayerOptions& options);

/// Boards, walls and roofs under slats with narrow slits between them. The distance between board and slats halves from
/// stand to stand, from size_m / 4 to size_m / 65536.
SynthScene make_slits(const LayerOptions& options);

}  // namespace gpvc::synth
