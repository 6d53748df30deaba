// The ground, houses, trees, lamps and bridge of the synthetic city.
#include <algorithm>

#include "app/synth/city.h"
#include "app/synth/city_parts.h"

namespace gpvc::synth {
namespace {

void add_balconies(SynthBuilder& builder, const Building& b, std::uint32_t seed) {
  constexpr double kFloor_m = 3, kBay_m = 5, kDepth_m = 1.3, kSlab_m = 0.2, kRail_m = 1.0, kThin_m = 0.1;
  constexpr double kIntoWall_m = 0.1;  // slabs end inside the wall, so that no two faces are coplanar
  for (int side = -1; side <= 1; side += 2)
    for (int floor = 1; (floor + 1) * kFloor_m <= b.height_m; ++floor)
      for (int bay = 0; (bay + 1) * kBay_m <= b.width_m; ++bay) {
        const auto n = static_cast<std::uint32_t>(floor * 64 + bay);
        if (synth_chance(seed, n, static_cast<std::uint32_t>(side + 1)) < 0.4) continue;
        const double x0 = -b.width_m / 2 + bay * kBay_m + 1.2, x1 = x0 + 2.6, z = floor * kFloor_m;
        const double wall = side * b.depth_m / 2, inner = wall - side * kIntoWall_m, outer = wall + side * kDepth_m;
        builder.box(Material::concrete, b.place, {x0, std::min(inner, outer), z},
                    {x1, std::max(inner, outer), z + kSlab_m}, true);
        const double rail = outer - side * kThin_m;
        builder.box(Material::concrete, b.place, {x0, std::min(rail, outer), z + kSlab_m},
                    {x1, std::max(rail, outer), z + kSlab_m + kRail_m}, false);
      }
}

void add_walls(SynthBuilder& builder, const Building& b, double height_m) {
  const double w = b.width_m, d = b.depth_m;
  const WorldPoint up{0, 0, height_m};
  builder.quad(b.walls, b.place({-w / 2, -d / 2, 0}), b.place.turn({w, 0, 0}), up, true);
  builder.quad(b.walls, b.place({w / 2, -d / 2, 0}), b.place.turn({0, d, 0}), up, true);
  builder.quad(b.walls, b.place({w / 2, d / 2, 0}), b.place.turn({-w, 0, 0}), up, true);
  builder.quad(b.walls, b.place({-w / 2, d / 2, 0}), b.place.turn({0, -d, 0}), up, true);
}

// Two slabs that overhang the walls on all sides; walls and gables end inside the slabs.
void add_gable_roof(SynthBuilder& builder, const Building& b, std::uint32_t seed) {
  constexpr double kSlope = 0.625, kEaves_m = 0.9, kVerge_m = 0.6, kThick_m = 0.3, kIntoSlab_m = 0.1;
  const double w = b.width_m, d = b.depth_m;
  add_walls(builder, b, b.height_m);
  const double ridge = b.height_m - kIntoSlab_m + kThick_m + kSlope * d / 2;
  const double gable = b.height_m + kSlope * d / 2;
  builder.triangle(b.walls, b.place({w / 2, -d / 2, b.height_m}), b.place({w / 2, d / 2, b.height_m}),
                   b.place({w / 2, 0, gable}));
  builder.triangle(b.walls, b.place({-w / 2, d / 2, b.height_m}), b.place({-w / 2, -d / 2, b.height_m}),
                   b.place({-w / 2, 0, gable}));
  const double run = d / 2 + kEaves_m, fall = kSlope * run, x = w / 2 + kVerge_m;
  const WorldPoint thick{0, 0, -kThick_m};
  for (int side = -1; side <= 1; side += 2) {
    // Seen from outside with the ridge up: u runs right, v from the eaves up to the ridge.
    const WorldPoint eaves = b.place({side * x, side * run, ridge - fall});
    const WorldPoint u = b.place.turn({-side * 2 * x, 0, 0}), v = b.place.turn({0, -side * run, fall});
    builder.surface(builder.quad(Material::tiles, eaves, u, v)).seed = seed;
    builder.quad(Material::concrete, eaves + thick + v, u, v * -1);           // soffit
    builder.quad(Material::concrete, eaves + thick, u, thick * -1);           // fascia
    builder.quad(Material::concrete, eaves + thick + v, v * -1, thick * -1);  // verges
    builder.quad(Material::concrete, eaves + u + thick, v, thick * -1);
  }
  const double cx = (synth_chance(seed, 5) - 0.5) * w * 0.6;
  builder.box(Material::brick, b.place, {cx - 0.5, 0.8, b.height_m + 0.5}, {cx + 0.5, 1.8, ridge + 1.0}, false);
}

void add_flat_roof(SynthBuilder& builder, const Building& b, std::uint32_t seed) {
  constexpr double kParapet_m = 0.8, kThick_m = 0.4;
  const double w = b.width_m, d = b.depth_m, top = b.height_m + kParapet_m, t = kThick_m;
  add_walls(builder, b, top);
  const auto at = [&](double x, double y, double z) { return b.place({x, y, z}); };
  const auto along = [&](double x, double y) { return b.place.turn({x, y, 0}); };
  const double iw = w - 2 * t, id = d - 2 * t;
  builder.quad(Material::concrete, at(-w / 2, -d / 2, top), along(w, 0), along(0, t));
  builder.quad(Material::concrete, at(-w / 2, d / 2 - t, top), along(w, 0), along(0, t));
  builder.quad(Material::concrete, at(-w / 2, -d / 2 + t, top), along(t, 0), along(0, id));
  builder.quad(Material::concrete, at(w / 2 - t, -d / 2 + t, top), along(t, 0), along(0, id));
  const WorldPoint up{0, 0, kParapet_m};
  builder.quad(Material::concrete, at(iw / 2, -id / 2, b.height_m), along(-iw, 0), up);
  builder.quad(Material::concrete, at(iw / 2, id / 2, b.height_m), along(0, -id), up);
  builder.quad(Material::concrete, at(-iw / 2, id / 2, b.height_m), along(iw, 0), up);
  builder.quad(Material::concrete, at(-iw / 2, -id / 2, b.height_m), along(0, id), up);
  builder.quad(Material::gravel, at(-iw / 2, -id / 2, b.height_m), along(iw, 0), along(0, id));
  const double x = (synth_chance(seed, 6) - 0.5) * iw * 0.5;
  builder.box(Material::concrete, b.place, {x - 1.5, -1, b.height_m - 0.1}, {x + 1.5, 1.2, b.height_m + 1.6}, false);
}

void add_building(SynthBuilder& builder, const Building& b) {
  if (synth_hash(b.seed, 8) % 3 == 0)
    add_flat_roof(builder, b, b.seed);
  else
    add_gable_roof(builder, b, b.seed);
  add_balconies(builder, b, b.seed);
}

void add_tree(SynthBuilder& builder, const WorldPoint& foot, std::uint32_t seed) {
  const double trunk = 2.2 + synth_chance(seed, 1), radius = 1.5 + 1.1 * synth_chance(seed, 2);
  builder.trunk(foot, trunk, 0.25);
  // The crown floats, as in meshes that lack thin branches: its lowest leaf is at least 0.1 m above the trunk.
  builder.ball(foot + WorldPoint{0, 0, trunk + 1.14 * radius + 0.1}, radius, seed);
}

// A street lamp: a thin pole with an arm over the street.
void add_lamp(SynthBuilder& builder, const WorldPoint& foot, double towards_y) {
  constexpr double kHigh_m = 6.5, kHalf_m = 0.07, kArm_m = 1.6;
  const Placement at{foot};
  builder.box(Material::metal, at, {-kHalf_m, -kHalf_m, 0}, {kHalf_m, kHalf_m, kHigh_m}, false);
  const double tip = towards_y * kArm_m;
  builder.box(Material::metal, at, {-kHalf_m, std::min(0.0, tip), kHigh_m},
              {kHalf_m, std::max(0.0, tip), kHigh_m + 0.12}, true);
}

// A footbridge along the middle of the street at y: deck, railings of posts and a rail, piers.
void add_bridge(SynthBuilder& builder, double y, double half_length) {
  constexpr double kDeck_m = 5, kThick_m = 0.5, kHalf_m = 1.6, kPier_m = 12, kPost_m = 2, kRail_m = 1.1;
  const Placement at{{0, y, 0}};
  builder.box(Material::concrete, at, {-half_length, -kHalf_m, kDeck_m}, {half_length, kHalf_m, kDeck_m + kThick_m},
              true);
  const double top = kDeck_m + kThick_m;
  for (double x = -half_length + 1; x < half_length; x += kPier_m)
    builder.box(Material::concrete, at, {x, -0.4, 0}, {x + 0.8, 0.4, kDeck_m}, false);
  for (int side = -1; side <= 1; side += 2) {
    const double rail = side * (kHalf_m - 0.1);
    for (double x = -half_length + 0.2; x < half_length; x += kPost_m)
      builder.box(Material::metal, at, {x, rail - 0.04, top}, {x + 0.08, rail + 0.04, top + kRail_m}, false);
    builder.box(Material::metal, at, {-half_length, rail - 0.05, top + kRail_m},
                {half_length, rail + 0.05, top + kRail_m + 0.1}, true);
  }
}

void build(SynthBuilder& builder, double size_m) {
  const double half = size_m / 2;
  builder.quad(Material::ground, {-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0});
  const int reach = blocks_each_way(size_m);
  for (int by = -reach; by <= reach; ++by)
    for (int bx = -reach; bx <= reach; ++bx) {
      const std::uint32_t seed = block_seed(builder.seed(), bx, by);
      const WorldPoint block{bx * kBlockPitch_m, by * kBlockPitch_m, 0};
      for (const Building& building : buildings_of(block, seed)) add_building(builder, building);
      const double kerb = kBlockPitch_m / 2 - kStreet_m / 2 - kWalk_m / 2;
      for (int side = 0; side < 4; ++side)
        for (int n = 0; n < 4; ++n) {
          const std::uint32_t tree = synth_hash(seed, static_cast<std::uint32_t>(side), static_cast<std::uint32_t>(n));
          if (tree % 3 == 0) continue;
          const double along = (n - 1.5) * 6.5 + 2 * (synth_chance(tree, 9) - 0.5);
          const double across = side < 2 ? -kerb : kerb;
          const WorldPoint at = side % 2 == 0 ? WorldPoint{along, across, 0} : WorldPoint{across, along, 0};
          const WorldPoint foot = block + at;
          if (std::max(std::abs(foot.x), std::abs(foot.y)) > half - 3) continue;
          add_tree(builder, foot, tree);
        }
      for (int side = -1; side <= 1; side += 2)
        for (int n = -1; n <= 1; n += 2) add_lamp(builder, block + WorldPoint{n * 13.4, side * (kerb + 0.6), 0}, side);
    }
  const double street = -kBlockPitch_m / 2;
  if (half > -street + 3) add_bridge(builder, street, 0.8 * half);
}

}  // namespace

int blocks_each_way(double size_m) {
  return static_cast<int>((size_m / 2 - (kBlockPitch_m - kStreet_m) / 2) / kBlockPitch_m);
}

std::uint32_t block_seed(std::uint32_t seed, int bx, int by) {
  return synth_hash(seed, static_cast<std::uint32_t>(bx + 1000), static_cast<std::uint32_t>(by + 1000));
}

std::vector<Building> buildings_of(const WorldPoint& block, std::uint32_t seed) {
  // Turned by exact Pythagorean angles.
  constexpr double kTurns[4][2] = {{1, 0}, {12.0 / 13, 5.0 / 13}, {40.0 / 41, -9.0 / 41}, {24.0 / 25, 7.0 / 25}};
  std::vector<Building> buildings;
  const auto add = [&](double y, std::uint32_t own) {
    const auto& turn = kTurns[synth_hash(own, 1) % 4];
    Building b;
    b.seed = own;
    b.place = {block + WorldPoint{0, y, 0}, turn[0], turn[1]};
    b.width_m = 12 + 2 * (synth_hash(own, 2) % 3);
    b.depth_m = 8 + synth_hash(own, 3) % 3;
    b.height_m = 6 + 3 * (synth_hash(own, 4) % 4);
    b.walls = synth_hash(own, 7) % 2 == 0 ? Material::plaster : Material::brick;
    buildings.push_back(b);
  };
  add(-6.5, synth_hash(seed, 1));
  if (synth_hash(seed, 2) % 4 != 0) add(6.5, synth_hash(seed, 3));
  return buildings;
}

SynthScene make_city(const CityOptions& options) {
  SynthScene scene = build_scene(options.faces, {0.005, 50, 1.002}, kCityGrid_per_m, options.flight.seed,
                                 [&](SynthBuilder& builder) { build(builder, options.flight.size_m); });
  scene.endless_ground = true;
  return scene;
}

}  // namespace gpvc::synth
