// Cars and people that stand elsewhere in each photo of the synthetic city, and wire fences.
#include <algorithm>

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

// All fences are one surface.
void add_fences(SynthBuilder& builder, const CityOptions& options) {
  const int reach = blocks_each_way(options.flight.size_m);
  for (int by = -reach; by <= reach; ++by)
    for (int bx = -reach; bx <= reach; ++bx)
      for (const Building& b :
           buildings_of({bx * kBlockPitch_m, by * kBlockPitch_m, 0}, block_seed(options.flight.seed, bx, by)))
        add_fence(builder, b);
}

}  // namespace

SynthScene make_unmodelled(const CityOptions& options, std::uint32_t photo, const Unmodelled& what) {
  SynthBuilder builder(10, kCityGrid_per_m, synth_hash(options.flight.seed, photo, 9001));
  const double half = options.flight.size_m / 2;
  for (int n = 0; n < what.cars; ++n) add_car(builder, half, builder.chance_seed(static_cast<std::uint32_t>(n), 1));
  for (int n = 0; n < what.people; ++n)
    add_person(builder, half, builder.chance_seed(static_cast<std::uint32_t>(n), 2));
  const auto fence = static_cast<std::uint32_t>(builder.surfaces());
  if (what.fences) add_fences(builder, options);
  SynthScene scene = builder.take();
  if (scene.surfaces.size() > fence) {
    scene.surfaces.resize(fence + 1);
    scene.surfaces[fence].seed = 1;
    scene.surfaces[fence].tint = {0.35, 0.6, 0.4};
  }
  for (std::uint32_t& surface : scene.face_surface) surface = std::min(surface, fence);
  return scene;
}

}  // namespace gpvc::synth
