// Where the synthetic city has its buildings.
#pragma once

#include <vector>

#include "app/synth/city.h"
#include "app/synth/synth_builder.h"

namespace gpvc::synth {

inline constexpr double kCityGrid_per_m = 1024;  ///< of coordinates: see SynthBuilder

struct Building {
  Placement place;                  ///< origin: the middle of the footprint, on the ground
  double width_m = 0, depth_m = 0;  ///< along x (the ridge), along y
  double height_m = 0;              ///< of the walls
  Material walls = Material::plaster;
  std::uint32_t seed = 0;
};

/// Blocks are numbered from -n to n in x and y, the middle of the scene being that of block 0, 0.
int blocks_each_way(double size_m);
std::uint32_t block_seed(std::uint32_t seed, int bx, int by);
/// One or two, of the block with this middle and seed.
std::vector<Building> buildings_of(const WorldPoint& block, std::uint32_t seed);

}  // namespace gpvc::synth
