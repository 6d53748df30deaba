// A few city blocks and a deterministic flight over them.
#pragma once

#include "app/synth/synth_scene.h"

namespace gpvc::synth {

/// Blocks repeat around the middle of the scene, with a street and its pavements between them.
inline constexpr double kBlockPitch_m = 36, kStreet_m = 8, kWalk_m = 2;

struct FlightOptions {
  int photos = 20;  ///< a fifth nadir, the rest oblique from four sides
  bool all_nadir = false;
  int width = 1200, height = 800;
  double size_m = 100;  ///< edge of the square below
  double range = 0.8;   ///< from the camera to what it looks at, times size_m
  double target_m = 0;  ///< height of what cameras look at
  std::uint32_t seed = 1;
  bool distorted = true;  ///< lens distortion and an off-centre principal point
};

/// Views in the order of their names, without photo paths.
std::vector<View> synth_flight(const FlightOptions& options);

struct CityOptions {
  FlightOptions flight;
  std::size_t faces = 60000;  ///< aimed at; the tessellation comes near
};

/// O(faces).
SynthScene make_city(const CityOptions& options);

/// What photos show and the mesh lacks.
struct Unmodelled {
  int cars = 0, people = 0;  ///< elsewhere in each photo
  // The same in all photos:
  bool fences = false;  ///< of wire, a metre before a wall of each building
  bool trees = false;   ///< four along the pavements of each block
  bool wires = false;   ///< overhead, along every second street, and their poles
  bool any() const { return cars > 0 || people > 0 || fences || trees || wires; }
};

/// What only photo number `photo` shows, and what all show. Surfaces are numbered from 0, as many in each photo. The same photo
/// shows the same every time.
SynthScene make_unmodelled(const CityOptions& options, std::uint32_t photo, const Unmodelled& what);

}  // namespace gpvc::synth
