// Cars and people that stand elsewhere in each photo of the synthetic city; wire fences, trees and overhead wires.
#include <algorithm>
#include <cmath>
#include <span>

#include "app/synth/city_parts.h"

namespace gpvc::synth {
namespace {

// A place along one of the streets: `across` metres to the right or left of its axis, by the seed.
Placement beside_a_street(double half_m, std::uint32_t seed, double across_m) {
  const int streets = std::max(1, static_cast<int>((half_m + kStreet_m / 2) / kBlockPitch_m) * 2);
  const int street = static_cast<int>(synth_hash(seed, 1) % static_cast<std::uint32_t>(streets));
  const double axis = (street / 2 + 0.5) * kBlockPitch_m * (street % 2 == 0 ? 1 : -1);
  const double along = (synth_chance(seed, 2) - 0.5) * 1.9 * half_m;
  const double lane = synth_hash(seed, 3) % 2 == 0 ? across_m : -across_m;
  if (synth_hash(seed, 4) % 2 == 0) return {{along, axis + lane, 0}};
  return {{axis + lane, along, 0}, 0, 1};
}

void add_car(SynthBuilder& builder, double half_m, std::uint32_t seed) {
  constexpr double kLength_m = 4.2, kWidth_m = 1.8, kLane_m = 1.9;
  constexpr Color kPaints[6] = {{1.1, 0.15, 0.12}, {0.12, 0.25, 0.95}, {1.2, 1.0, 0.1},
                                {0.1, 0.1, 0.12},  {0.15, 0.8, 0.75},  {1.0, 0.45, 0.9}};
  const Placement place = beside_a_street(half_m, seed, kLane_m);
  const std::size_t first = builder.surfaces();
  builder.box(Material::paint, place, {-kLength_m / 2, -kWidth_m / 2, 0.25}, {kLength_m / 2, kWidth_m / 2, 0.85}, true);
  builder.box(Material::paint, place, {-kLength_m / 4, -0.45 * kWidth_m, 0.85}, {kLength_m / 3, 0.45 * kWidth_m, 1.4},
              false);
  for (std::size_t s = first; s < builder.surfaces(); ++s)
    builder.surface(static_cast<std::uint32_t>(s)).tint = kPaints[synth_hash(seed, 5) % 6];
}

// Legs, trunk and head of somebody on the pavement or at the street's border.
void add_person(SynthBuilder& builder, double half_m, std::uint32_t seed) {
  constexpr Color kClothes[6] = {{0.9, 0.1, 0.1},    {0.1, 0.15, 0.5}, {0.95, 0.95, 0.9},
                                 {0.08, 0.08, 0.09}, {0.9, 0.75, 0.1}, {0.2, 0.5, 0.25}};
  constexpr Color kSkins[2] = {{0.95, 0.72, 0.6}, {0.45, 0.3, 0.22}};
  const Placement place = beside_a_street(half_m, seed, kStreet_m / 2 - 0.5 + 2 * synth_chance(seed, 6));
  const auto part = [&](const WorldPoint& lo, const WorldPoint& hi, const Color& tint) {
    const std::size_t first = builder.surfaces();
    builder.box(Material::paint, place, lo, hi, true);
    for (std::size_t s = first; s < builder.surfaces(); ++s) builder.surface(static_cast<std::uint32_t>(s)).tint = tint;
  };
  part({-0.11, -0.16, 0}, {0.11, 0.16, 0.84}, kClothes[synth_hash(seed, 7) % 6]);
  part({-0.14, -0.25, 0.84}, {0.14, 0.25, 1.48}, kClothes[synth_hash(seed, 8) % 6]);
  part({-0.11, -0.09, 1.5}, {0.11, 0.09, 1.74}, kSkins[synth_hash(seed, 9) % 2]);
}

// A mesh of flat wires, 3 cm wide, between posts.
void add_fence(SynthBuilder& builder, const Building& b) {
  constexpr double kOff_m = 1, kHigh_m = 2.2, kPitch_m = 0.2, kWire_m = 0.03, kPost_m = 0.08, kPosts_m = 2.5;
  const double y = -b.depth_m / 2 - kOff_m, w = b.width_m;
  const auto wires = [](double length_m) { return static_cast<int>(length_m / kPitch_m); };
  for (int n = 1; n < wires(w); ++n)
    builder.quad(Material::metal, b.place({-w / 2 + n * kPitch_m, y, 0}), b.place.turn({kWire_m, 0, 0}),
                 {0, 0, kHigh_m});
  for (int n = 1; n <= wires(kHigh_m); ++n)
    builder.quad(Material::metal, b.place({-w / 2, y, n * kPitch_m - kWire_m}), b.place.turn({w, 0, 0}),
                 {0, 0, kWire_m});
  for (double x = -w / 2; x <= w / 2; x += kPosts_m)
    builder.box(Material::metal, b.place, {x, y - kPost_m, 0}, {x + kPost_m, y, kHigh_m + 0.1}, false);
}

// Calls body(middle of the block, its seed) for every block.
template <class Body>
void for_each_block(const CityOptions& options, Body body) {
  const int reach = blocks_each_way(options.flight.size_m);
  for (int by = -reach; by <= reach; ++by)
    for (int bx = -reach; bx <= reach; ++bx)
      body(WorldPoint{bx * kBlockPitch_m, by * kBlockPitch_m, 0}, block_seed(options.flight.seed, bx, by));
}

void add_fences(SynthBuilder& builder, const CityOptions& options) {
  for_each_block(options, [&](const WorldPoint& block, std::uint32_t seed) {
    for (const Building& b : buildings_of(block, seed)) add_fence(builder, b);
  });
}

// Evenly over the sphere, without a sine.
WorldPoint any_direction(std::uint32_t seed) {
  for (std::uint32_t n = 0;; ++n) {
    const WorldPoint d{2 * synth_chance(seed, n, 1) - 1, 2 * synth_chance(seed, n, 2) - 1,
                       2 * synth_chance(seed, n, 3) - 1};
    const double square = dot(d, d);
    if (square > 0.01 && square <= 1) return unit(d);
  }
}

// A crown of square sprays of leaves, turned in all directions. From above they leave a sixth of the crown open.
void add_crown(SynthBuilder& builder, const WorldPoint& centre, double radius_m, std::uint32_t seed) {
  constexpr double kSpray_m = 0.4, kLayers = 1.8;  // exp(-1.8) = 1/6
  constexpr double kSeen = 0.5;                    // of a square's area, on the average over directions
  const double pi = 3.14159265358979;
  const int sprays = static_cast<int>(kLayers * pi * radius_m * radius_m / (kSeen * kSpray_m * kSpray_m));
  for (int n = 0; n < sprays; ++n) {
    const std::uint32_t mine = synth_hash(seed, static_cast<std::uint32_t>(n));
    const double from_middle = radius_m * std::sqrt(synth_chance(mine, 8));
    const WorldPoint u = any_direction(synth_hash(mine, 6)), v = unit(cross(u, any_direction(synth_hash(mine, 7))));
    builder.quad(Material::leaves, centre + from_middle * any_direction(mine), kSpray_m * u, kSpray_m * v);
  }
}

double half_block() { return (kBlockPitch_m - kStreet_m) / 2; }

// Along the pavements of each block: crowns hang over pavement, street and garden.
void add_trees(SynthBuilder& builder, const CityOptions& options, bool crowns) {
  constexpr std::uint32_t kTrees = 4;
  constexpr double kPole_m = 0.2;
  for_each_block(options, [&](const WorldPoint& block, std::uint32_t seed) {
    for (std::uint32_t n = 0; n < kTrees; ++n) {
      const std::uint32_t tree = synth_hash(seed, n, 9101);
      const double along = 1.6 * half_block() * (synth_chance(tree, 1) - 0.5), across = half_block() - 1.2;
      const Placement side{block, n < 2 ? 1.0 : 0.0, n < 2 ? 0.0 : 1.0};
      const WorldPoint foot = side({along, n % 2 == 0 ? across : -across, 0});
      const double radius = 1.6 + 1.2 * synth_chance(tree, 2), height = 2.4 + radius + synth_chance(tree, 3);
      if (crowns)
        add_crown(builder, foot + WorldPoint{0, 0, height}, radius, tree);
      else
        builder.trunk(foot, height, kPole_m);
    }
  });
}

// Three wires along each street that runs along x, and poles.
void add_wires(SynthBuilder& builder, const CityOptions& options) {
  constexpr double kWire_m = 0.06, kApart_m = 0.7, kHigh_m = 7.5, kPole_m = 0.12;
  const int reach = blocks_each_way(options.flight.size_m);
  const double end = (reach + 0.5) * kBlockPitch_m;
  for (int street = -reach; street <= reach; ++street) {
    const double y = (street + 0.5) * kBlockPitch_m - kStreet_m / 2 - 0.4;
    for (int wire = -1; wire <= 1; ++wire) {
      const WorldPoint from{-end, y + wire * kApart_m, kHigh_m}, along{2 * end, 0, 0};
      builder.quad(Material::metal, from, along, {0, kWire_m, 0});
      builder.quad(Material::metal, from, along, {0, 0, kWire_m});
    }
    for (int pole = -reach; pole <= reach; ++pole) {
      const double x = pole * kBlockPitch_m + 0.3 * kBlockPitch_m;
      builder.box(Material::metal, {}, {x - kPole_m, y - kPole_m, 0}, {x + kPole_m, y + kPole_m, kHigh_m + 0.3}, false);
    }
  }
}

// Surfaces from `first` on that are one, and how it looks.
struct OneSurface {
  std::size_t first;
  Color tint;
};

// Makes one surface of those of each kind.
void unite(SynthScene& scene, std::span<const OneSurface> kinds) {
  if (kinds.empty()) return;
  std::vector<Surface> surfaces(scene.surfaces.begin(),
                                scene.surfaces.begin() + static_cast<std::ptrdiff_t>(kinds[0].first));
  for (const OneSurface& kind : kinds) {
    surfaces.push_back(scene.surfaces[kind.first]);
    surfaces.back().seed = 1;
    surfaces.back().tint = kind.tint;
  }
  for (std::uint32_t& surface : scene.face_surface) {
    const auto kind = std::ranges::upper_bound(kinds, surface, {}, &OneSurface::first) - kinds.begin();
    if (kind > 0) surface = static_cast<std::uint32_t>(kinds[0].first) + static_cast<std::uint32_t>(kind) - 1;
  }
  scene.surfaces = std::move(surfaces);
}

}  // namespace

SynthScene make_unmodelled(const CityOptions& options, std::uint32_t photo, const Unmodelled& what) {
  SynthBuilder builder(10, kCityGrid_per_m, synth_hash(options.flight.seed, photo, 9001));
  const double half = options.flight.size_m / 2;
  for (int n = 0; n < what.cars; ++n) add_car(builder, half, builder.chance_seed(static_cast<std::uint32_t>(n), 1));
  for (int n = 0; n < what.people; ++n)
    add_person(builder, half, builder.chance_seed(static_cast<std::uint32_t>(n), 2));
  std::vector<OneSurface> kinds;
  const auto add = [&](bool wanted, const Color& tint, auto add_all) {
    const std::size_t first = builder.surfaces();
    if (wanted) add_all();
    if (builder.surfaces() > first) kinds.push_back({first, tint});
  };
  add(what.fences, {0.35, 0.6, 0.4}, [&] { add_fences(builder, options); });
  add(what.trees, {1, 1, 1}, [&] { add_trees(builder, options, true); });
  add(what.trees, {1, 1, 1}, [&] { add_trees(builder, options, false); });
  add(what.wires, {0.3, 0.3, 0.35}, [&] { add_wires(builder, options); });
  SynthScene scene = builder.take();
  unite(scene, kinds);
  return scene;
}

}  // namespace gpvc::synth
