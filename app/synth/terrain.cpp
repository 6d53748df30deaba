#include "app/synth/terrain.h"

#include <algorithm>
#include <functional>

#include "app/synth/synth_builder.h"

namespace gpvc::synth {
namespace {

constexpr double kTerrainGrid = 1024, kSlitsGrid = 1048576;

// The edge length at which `build` makes about as many faces as asked for.
double edge_for(std::size_t faces, double size_m, double grid, std::uint32_t seed,
                const std::function<void(SynthBuilder&)>& build) {
  double fine = size_m * 1e-5, coarse = size_m, best = coarse;
  std::size_t best_miss = SIZE_MAX;
  for (int step = 0; step < 24; ++step) {
    const double middle = std::sqrt(fine * coarse);
    SynthBuilder counter(middle, grid, seed, true);
    build(counter);
    const std::size_t made = counter.faces(), miss = made > faces ? made - faces : faces - made;
    (made > faces ? fine : coarse) = middle;
    if (miss >= best_miss) continue;
    best_miss = miss;
    best = middle;
  }
  return best;
}

SynthScene built(const LayerOptions& options, double grid, const std::function<void(SynthBuilder&)>& build) {
  SynthBuilder builder(edge_for(options.faces, options.size_m, grid, options.seed, build), grid, options.seed);
  build(builder);
  return builder.take();
}

// Colours far apart: a hue from the wheel's twelve, at two strengths.
Color vivid(std::uint32_t n) {
  constexpr Color kHues[12] = {{1.5, 0.5, 0.5}, {0.4, 1.3, 0.6}, {0.5, 0.6, 1.6}, {1.5, 1.4, 0.4},
                               {1.4, 0.5, 1.4}, {0.4, 1.3, 1.4}, {1.6, 0.9, 0.4}, {0.8, 0.5, 1.6},
                               {0.8, 1.5, 0.4}, {0.4, 0.8, 0.9}, {1.4, 1.1, 1.0}, {0.7, 0.4, 0.4}};
  return kHues[n % 12];
}

}  // namespace

SynthScene make_terrain(const LayerOptions& options) {
  constexpr int kFields = 9;  // a side; every other one, in a worn pattern, lies under a sheet
  const double half = options.size_m / 2, scale = options.size_m / 100, field = options.size_m / kFields;
  const auto hills = [&](double x, double y) {
    const double u = x / options.size_m * 5, v = y / options.size_m * 5;
    return options.size_m *
           (0.07 * synth_noise(u, v, options.seed + 3) + 0.02 * synth_noise(3 * u, 3 * v, options.seed + 4));
  };
  const auto build = [&](SynthBuilder& builder) {
    const WorldPoint south_west{-half, -half, 0}, north_east{half, half, 0};
    builder.surface(builder.relief(Material::meadow, south_west, north_east, hills)).scale = scale;
    for (int j = 0; j < kFields; ++j)
      for (int i = 0; i < kFields; ++i) {
        const std::uint32_t seed = builder.chance_seed(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
        if (((i + j) % 2 == 0) == (synth_hash(seed, 1) % 5 == 0)) continue;
        // Rounded to the cells inside, so that no sheet has its border on a neighbour's.
        const auto margin = [&](std::uint32_t n) { return 0.15 * field * synth_chance(seed, n); };
        const WorldPoint lo{-half + i * field + margin(2), -half + j * field + margin(3), 0};
        const WorldPoint hi{-half + (i + 1) * field - margin(4), -half + (j + 1) * field - margin(5), 0};
        const auto sheet = builder.relief_part(Material::gravel, south_west, north_east, lo, hi,
                                               [&](double x, double y) { return hills(x, y) + options.gap_m; });
        if (!sheet) continue;  // fields smaller than a cell
        builder.surface(*sheet).scale = scale;
        builder.surface(*sheet).tint = vivid(synth_hash(seed, 6));
      }
  };
  return built(options, kTerrainGrid, build);
}

namespace {

// A slat: a thin plate from p over u and v, `thick` in the direction of `normal`, closed on all sides.
void add_slat(SynthBuilder& builder, const WorldPoint& p, const WorldPoint& u, const WorldPoint& v,
              const WorldPoint& normal, double thick, double scale, std::uint32_t seed) {
  const WorldPoint t = normal * thick;
  const std::size_t first = builder.surfaces();
  builder.quad(Material::concrete, p + t, u, v);
  builder.quad(Material::concrete, p + v, u, v * -1);
  builder.quad(Material::concrete, p, u, t);
  builder.quad(Material::concrete, p + u, v, t);
  builder.quad(Material::concrete, p + u + v, u * -1, t);
  builder.quad(Material::concrete, p + v, v * -1, t);
  for (std::size_t s = first; s < builder.surfaces(); ++s) {
    Surface& surface = builder.surface(static_cast<std::uint32_t>(s));
    surface.scale = scale;
    surface.tint = vivid(seed + static_cast<std::uint32_t>(s - first));
  }
}

// A board and, `gap` in front of it, slats across it. The board spans u and v from p and is seen from u x v.
void add_stand(SynthBuilder& builder, const WorldPoint& p, const WorldPoint& u, const WorldPoint& v, double gap,
               double scale, std::uint32_t seed) {
  const WorldPoint normal = unit(WorldPoint{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x});
  const std::uint32_t board = builder.quad(Material::brick, p, u, v);
  builder.surface(board).scale = scale;
  builder.surface(board).tint = vivid(seed);
  const double across = length(u), slat = 0.09 * across, thick = std::min(gap, slat) / 2;
  const WorldPoint step = u * (1 / across);
  // Slits as wide as a slat, half and a quarter of it in turn.
  double at = 0.06 * across;
  for (std::uint32_t n = 0; at + slat <= across; ++n) {
    add_slat(builder, p + normal * gap + step * at, step * slat, v, normal, thick, scale, seed + 2 + 4 * (n % 2));
    at += slat * (1 + 1.0 / (1u << (n % 3)));
  }
}

}  // namespace

SynthScene make_slits(const LayerOptions& options) {
  constexpr int kStands = 4;  // a side
  const double half = options.size_m / 2, cell = options.size_m / kStands, board = 0.66 * cell;
  const auto build = [&](SynthBuilder& builder) {
    builder.surface(builder.quad(Material::gravel, {-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0})).scale =
        options.size_m / 20;
    for (int n = 0; n < kStands * kStands; ++n) {
      const auto seed = static_cast<std::uint32_t>(n);
      // Shuffled, so that wide and narrow gaps meet all kinds of stands.
      const int halvings = (n * 7) % (kStands * kStands) * 14 / 15;
      const double gap = options.size_m / 4 / static_cast<double>(1u << halvings);
      const double x = -half + (n % kStands + 0.17) * cell, y = -half + (n / kStands + 0.17) * cell;
      const double low = 0.04 * cell, scale = options.size_m / 20;
      switch (n % 4) {
        case 0:  // a table
          add_stand(builder, {x, y, low}, {board, 0, 0}, {0, board, 0}, gap, scale, seed);
          break;
        case 1:  // a roof that falls to the south
          add_stand(builder, {x, y, low}, {board, 0, 0}, {0, 0.8 * board, 0.6 * board}, gap, scale, seed);
          break;
        case 2:  // a roof that falls to the west, its slats level
          add_stand(builder, {x + board, y + board, low + 0.6 * board}, {-0.8 * board, 0, -0.6 * board}, {0, -board, 0},
                    gap, scale, seed);
          break;
        default:  // a wall that faces south-east
          add_stand(builder, {x, y + 0.2 * board, low}, {0.8 * board, 0.6 * board, 0}, {0, 0, board}, gap, scale, seed);
      }
    }
  };
  return built(options, kSlitsGrid, build);
}

}  // namespace gpvc::synth
