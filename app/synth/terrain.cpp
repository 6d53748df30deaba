#include "app/synth/terrain.h"

#include <algorithm>
#include <functional>

#include "app/synth/synth_builder.h"

namespace gpvc::synth {
namespace {

constexpr double kTerrainGrid_per_m = 1024, kSlitsGrid_per_m = 1048576;

SynthScene build_layers(const LayerOptions& options, double grid_per_m,
                        const std::function<void(SynthBuilder&)>& build) {
  return build_scene(options.faces, {options.size_m * 1e-5, options.size_m}, grid_per_m, options.seed, build);
}

// One of twelve hues that differ strongly.
Color vivid(std::uint32_t n) {
  constexpr Color kHues[12] = {{1.5, 0.5, 0.5}, {0.4, 1.3, 0.6}, {0.5, 0.6, 1.6}, {1.5, 1.4, 0.4},
                               {1.4, 0.5, 1.4}, {0.4, 1.3, 1.4}, {1.6, 0.9, 0.4}, {0.8, 0.5, 1.6},
                               {0.8, 1.5, 0.4}, {0.4, 0.8, 0.9}, {1.4, 1.1, 1.0}, {0.7, 0.4, 0.4}};
  return kHues[n % 12];
}

}  // namespace

SynthScene make_terrain(const LayerOptions& options) {
  constexpr int kFields = 9;  // on a side; a sheet covers about every other one, in an irregular checkerboard
  const double half = options.size_m / 2, scale = options.size_m / 100, field = options.size_m / kFields;
  const auto hills = [&](double x, double y) {
    const double u = x / options.size_m * 5, v = y / options.size_m * 5;
    return options.size_m *
           (0.07 * synth_noise(u, v, options.seed + 3) + 0.02 * synth_noise(3 * u, 3 * v, options.seed + 4));
  };
  const auto build = [&](SynthBuilder& builder) {
    const WorldPoint south_west{-half, -half, 0}, north_east{half, half, 0};
    builder.surface(*builder.relief(Material::meadow, south_west, north_east, south_west, north_east, hills)).scale =
        scale;
    for (int j = 0; j < kFields; ++j)
      for (int i = 0; i < kFields; ++i) {
        const std::uint32_t seed = builder.chance_seed(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
        if (((i + j) % 2 == 0) == (synth_hash(seed, 1) % 5 == 0)) continue;
        // Sheets consist of the cells inside these bounds, so that borders of neighbouring sheets do not coincide.
        const auto margin = [&](std::uint32_t n) { return 0.15 * field * synth_chance(seed, n); };
        const WorldPoint lo{-half + i * field + margin(2), -half + j * field + margin(3), 0};
        const WorldPoint hi{-half + (i + 1) * field - margin(4), -half + (j + 1) * field - margin(5), 0};
        const auto sheet = builder.relief(Material::gravel, south_west, north_east, lo, hi,
                                          [&](double x, double y) { return hills(x, y) + options.gap_m; });
        if (!sheet) continue;  // fields smaller than a cell
        builder.surface(*sheet).scale = scale;
        builder.surface(*sheet).tint = vivid(synth_hash(seed, 6));
      }
  };
  return build_layers(options, kTerrainGrid_per_m, build);
}

namespace {

/// A parallelogram that faces the direction u x v.
struct Plate {
  WorldPoint p, u, v;
};

struct Finish {
  double scale;  // of the pattern
  std::uint32_t seed;
};

// A box: the plate, and the plate moved by `thickness`, which points to the side it faces.
void add_slat(SynthBuilder& builder, const Plate& plate, const WorldPoint& thickness, const Finish& finish) {
  const auto& [p, u, v] = plate;
  const WorldPoint& t = thickness;
  const std::size_t first = builder.surfaces();
  builder.quad(Material::concrete, p + t, u, v);
  builder.quad(Material::concrete, p + v, u, v * -1);
  builder.quad(Material::concrete, p, u, t);
  builder.quad(Material::concrete, p + u, v, t);
  builder.quad(Material::concrete, p + u + v, u * -1, t);
  builder.quad(Material::concrete, p + v, v * -1, t);
  for (std::size_t s = first; s < builder.surfaces(); ++s) {
    Surface& surface = builder.surface(static_cast<std::uint32_t>(s));
    surface.scale = finish.scale;
    surface.tint = vivid(finish.seed + static_cast<std::uint32_t>(s - first));
  }
}

// A board and, `gap_m` in front of it, slats across it.
void add_stand(SynthBuilder& builder, const Plate& board, double gap_m, const Finish& finish) {
  const auto& [p, u, v] = board;
  const WorldPoint normal = unit(cross(u, v));
  Surface& surface = builder.surface(builder.quad(Material::brick, p, u, v));
  surface.scale = finish.scale;
  surface.tint = vivid(finish.seed);
  const double across_m = length(u), slat_m = 0.09 * across_m, thick_m = std::min(gap_m, slat_m) / 2;
  const WorldPoint step = u * (1 / across_m);
  // The slits are as wide as a slat, half and a quarter of it in turn.
  double at_m = 0.06 * across_m;
  for (std::uint32_t n = 0; at_m + slat_m <= across_m; ++n) {
    add_slat(builder, {p + normal * gap_m + step * at_m, step * slat_m, v}, normal * thick_m,
             {finish.scale, finish.seed + 2 + 4 * (n % 2)});
    at_m += slat_m * (1 + 1.0 / (1u << (n % 3)));
  }
}

}  // namespace

SynthScene make_slits(const LayerOptions& options) {
  constexpr int kStands = 4;  // on a side
  const double half = options.size_m / 2, cell = options.size_m / kStands, board = 0.66 * cell, low = 0.04 * cell;
  const double scale = options.size_m / 20;
  const auto plate = [&](int n) -> Plate {
    const double x = -half + (n % kStands + 0.17) * cell, y = -half + (n / kStands + 0.17) * cell;
    switch (n % 4) {
      case 0:  // a table
        return {{x, y, low}, {board, 0, 0}, {0, board, 0}};
      case 1:  // a roof that falls to the south
        return {{x, y, low}, {board, 0, 0}, {0, 0.8 * board, 0.6 * board}};
      case 2:  // a roof that falls to the west, with level slats
        return {{x + board, y + board, low + 0.6 * board}, {-0.8 * board, 0, -0.6 * board}, {0, -board, 0}};
      default:  // a wall that faces south-east
        return {{x, y + 0.2 * board, low}, {0.8 * board, 0.6 * board, 0}, {0, 0, board}};
    }
  };
  const auto build = [&](SynthBuilder& builder) {
    builder.surface(builder.quad(Material::gravel, {-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0})).scale =
        scale;
    for (int n = 0; n < kStands * kStands; ++n) {
      // In an order in which every kind of stand gets wide and narrow gaps.
      const int halvings = (n * 7) % (kStands * kStands) * 14 / 15;
      const double gap_m = options.size_m / 4 / static_cast<double>(1u << halvings);
      add_stand(builder, plate(n), gap_m, {scale, static_cast<std::uint32_t>(n)});
    }
  };
  return build_layers(options, kSlitsGrid_per_m, build);
}

}  // namespace gpvc::synth
