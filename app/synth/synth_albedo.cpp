// The colours of synthetic surfaces.
#include <algorithm>
#include <cmath>

#include "app/synth/city.h"
#include "app/synth/synth_scene.h"

namespace gpvc::synth {
namespace {

struct Cell {
  std::int64_t index;
  double inside;  // [0, 1)
};

Cell cell(double v) {
  const double floor = std::floor(v);
  return {static_cast<std::int64_t>(floor), v - floor};
}

std::uint32_t bits(std::int64_t v) { return static_cast<std::uint32_t>(v); }

Color mix(const Color& a, const Color& b, double t) {
  return {a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t};
}
Color scale(const Color& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }

// Noise of three octaves in [-1, 1]: patches of the size 1 / frequency, half and a quarter of it.
double rough(double u, double v, double frequency, std::uint32_t seed) {
  const double a = synth_noise(u * frequency, v * frequency, seed),
               b = synth_noise(u * frequency * 2, v * frequency * 2, seed + 1),
               c = synth_noise(u * frequency * 4, v * frequency * 4, seed + 2);
  return (a * 4 + b * 2 + c) * (2.0 / 7) - 1;
}

// Streets, pavements and gardens. Blocks repeat around the middle of the scene, also beyond the mesh.
Color ground(double x, double y) {
  const Cell bx = cell(x / kBlockPitch_m + 0.5), by = cell(y / kBlockPitch_m + 0.5);
  const double px = std::abs(bx.inside - 0.5) * kBlockPitch_m, py = std::abs(by.inside - 0.5) * kBlockPitch_m;
  const double half_block = (kBlockPitch_m - kStreet_m) / 2, reach = std::max(px, py);
  const double to_axis_x = kBlockPitch_m / 2 - px, to_axis_y = kBlockPitch_m / 2 - py;  // of the streets
  if (reach > half_block) {
    Color c = scale({96, 98, 102}, 1 + 0.16 * rough(x, y, 1.5, 11) + 0.10 * rough(x, y, 0.15, 14));
    const bool crossing = px > half_block && py > half_block;
    const double along = px > half_block ? y : x, axis = px > half_block ? to_axis_x : to_axis_y;
    const double from_crossing = px > half_block ? py : px;
    if (!crossing && from_crossing > half_block - 3.5 && from_crossing < half_block - 0.8 &&
        cell(axis / 1.1).inside < 0.55)
      c = mix(c, {226, 226, 222}, 0.9);  // zebra
    else if (!crossing && axis < 0.12 && cell(along / 3).inside < 0.5)
      c = mix(c, {230, 228, 214}, 0.9);  // centre line
    return c;
  }
  if (reach > half_block - kWalk_m) {
    const Cell sx = cell(x / 0.8), sy = cell(y / 0.8);
    const double slab = 0.9 + 0.2 * synth_chance(bits(sx.index), bits(sy.index), 21);
    const bool joint = std::min(sx.inside, sy.inside) < 0.07 || reach > half_block - 0.2;
    return scale({168, 164, 156}, slab * (joint ? 0.72 : 1) * (1 + 0.07 * rough(x, y, 2, 22)));
  }
  const double dry = 0.5 + 0.5 * rough(x, y, 0.12, 31);
  const Color grass = mix({74, 104, 48}, {126, 128, 70}, dry);
  Color c = scale(grass, 1 + 0.32 * rough(x, y, 1.8, 32));
  if (std::abs(to_axis_y - kBlockPitch_m / 2) < 0.7 || std::abs(to_axis_x - kBlockPitch_m / 2) < 0.7)
    c = scale({186, 172, 140}, 1 + 0.12 * rough(x, y, 3, 35));  // garden paths
  return c;
}

// Where in its window a point of a wall lies, in metres from the bay's and the floor's lower left corner.
struct WindowPlace {
  Cell bay, floor;
  double u = 0, v = 0;
  WindowPlace(double wall_u, double wall_v)
      : bay(cell(wall_u / 2.5)), floor(cell(wall_v / 3.0)), u(bay.inside * 2.5), v(floor.inside * 3) {}
  bool window() const { return u >= 0.6 && u <= 1.9 && v >= 0.9 && v <= 2.4; }
  bool frame() const { return u < 0.72 || u > 1.78 || v < 1.02 || v > 2.28 || std::abs(u - 1.25) < 0.06; }
};

Color wall(const Surface& s, double u, double v) {
  Color c;
  if (s.material == Material::brick) {
    const Cell row = cell(v / 0.3), column = cell(u / 0.7 + (row.index % 2 == 0 ? 0.0 : 0.5));
    const double tone = synth_chance(bits(row.index), bits(column.index), s.seed);
    c = mix({138, 66, 48}, {186, 108, 80}, tone);
    if (row.inside < 0.13 || column.inside < 0.06) c = {190, 180, 164};
  } else {
    const Color paints[4] = {{222, 206, 170}, {206, 186, 176}, {190, 200, 206}, {230, 224, 206}};
    c = paints[synth_hash(s.seed, 3) % 4];
  }
  c = scale(c, 1 + 0.10 * rough(u, v, 1.2, s.seed) + 0.06 * rough(u, v, 0.2, s.seed + 9));
  if (!s.windows) return c;
  const WindowPlace at(u, v);
  if (!at.window()) return c;
  if (at.frame()) return {236, 236, 232};
  const double curtain = synth_chance(bits(at.bay.index), bits(at.floor.index), s.seed + 4);
  const Color glass = mix({40, 52, 66}, {104, 124, 142}, (at.v - 0.9) / 1.5);
  return curtain > 0.6 && at.v > 2.4 - curtain ? Color{214, 206, 190} : glass;
}

Color tiles(const Surface& s, double u, double v) {
  const Cell row = cell(v / 0.45), column = cell(u / 0.5 + (row.index % 2 == 0 ? 0.0 : 0.5));
  const double tone = synth_chance(bits(row.index), bits(column.index), s.seed);
  const Color dark[2] = {{120, 52, 36}, {72, 74, 82}}, light[2] = {{188, 98, 66}, {120, 120, 126}};
  const std::size_t kind = synth_hash(s.seed / 4, 8) % 3 == 0 ? 1 : 0;
  const double edge = row.inside < 0.2 ? 0.7 : 1 - 0.15 * std::abs(column.inside - 0.5);
  return scale(mix(dark[kind], light[kind], tone), edge * (1 + 0.12 * rough(u, v, 0.25, s.seed + 1)));
}

// Pasture, scrub and bare ground, in patches of some metres.
Color meadow(const Surface& s, double u, double v) {
  const double dry = 0.5 + 0.5 * rough(u, v, 0.11, s.seed), bare = rough(u, v, 0.05, s.seed + 5);
  Color c = mix({86, 112, 58}, {150, 142, 88}, dry);
  if (bare > 0.25) c = mix(c, {146, 126, 104}, std::min(1.0, (bare - 0.25) * 6));
  return scale(c, 1 + 0.3 * rough(u, v, 0.9, s.seed + 2));
}

// A place on a surface, in metres of its pattern: from its origin, and along its axes.
struct PatternPlace {
  double dx, dy, dz, u, v;
  PatternPlace(const Surface& s, const WorldPoint& p)
      : dx((p.x - s.origin.x) / s.scale),
        dy((p.y - s.origin.y) / s.scale),
        dz((p.z - s.origin.z) / s.scale),
        u(dx * s.u_axis.x + dy * s.u_axis.y + dz * s.u_axis.z),
        v(dx * s.v_axis.x + dy * s.v_axis.y + dz * s.v_axis.z) {}
};

Color untinted(const Surface& s, const WorldPoint& p) {
  const auto [dx, dy, dz, u, v] = PatternPlace(s, p);
  switch (s.material) {
    case Material::ground:
      return ground(p.x, p.y);
    case Material::plaster:
    case Material::brick:
      return wall(s, u, v);
    case Material::tiles:
      return tiles(s, u, v);
    case Material::gravel:
      return scale({150, 146, 140}, 1 + 0.3 * rough(u, v, 3, s.seed) + 0.12 * rough(u, v, 0.3, s.seed + 7));
    case Material::concrete:
      return scale({178, 176, 170}, 1 + 0.14 * rough(u, v, 1.5, s.seed));
    case Material::bark:
      return scale({96, 72, 50}, 1 + 0.4 * rough(u * 3, v, 2, s.seed));
    case Material::leaves:
      return scale(mix({44, 82, 30}, {120, 142, 56}, synth_noise(dx * 2 + dz, dy * 2 - dz, s.seed)),
                   1 + 0.35 * rough(dx + 0.7 * dz, dy - 0.6 * dz, 2.2, s.seed + 3));
    case Material::metal:
      return scale({158, 162, 168}, 1 + 0.06 * rough(u, v, 2, s.seed));
    case Material::paint:
      return scale({200, 200, 200}, 1 + 0.05 * rough(u, v, 1, s.seed));
    case Material::meadow:
      return meadow(s, u, v);
  }
  return {255, 0, 255};
}

}  // namespace

double synth_noise(double x, double y, std::uint32_t seed) {
  const Cell cx = cell(x), cy = cell(y);
  const auto corner = [&](int dx, int dy) { return synth_chance(bits(cx.index + dx), bits(cy.index + dy), seed); };
  const double sx = cx.inside * cx.inside * (3 - 2 * cx.inside), sy = cy.inside * cy.inside * (3 - 2 * cy.inside);
  const double low = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * sx;
  const double high = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * sx;
  return low + (high - low) * sy;
}

bool in_window_pane(const Surface& s, const WorldPoint& p) {
  if (!s.windows || (s.material != Material::plaster && s.material != Material::brick)) return false;
  const PatternPlace place(s, p);
  const WindowPlace at(place.u, place.v);
  return at.window() && !at.frame();
}

Color surface_albedo(const Surface& s, const WorldPoint& p) {
  const Color c = untinted(s, p);
  return {c[0] * s.tint[0], c[1] * s.tint[1], c[2] * s.tint[2]};
}

double surface_reflectance(const Surface& s, const WorldPoint& p, double wavelength_nm) {
  constexpr double kFactors[] = {1.0, 0.95, 1.15, 1.1, 1.05, 0.9, 1.2, 1.0, 0.8, 0.85, 1.05};  // of materials
  const Color c = surface_albedo(s, p);
  const double red = c[0] / 255, green = c[1] / 255, blue = c[2] / 255;
  const double infrared =
      kFactors[static_cast<std::size_t>(s.material)] * red + 1.2 * std::max(0.0, green - (red + blue) / 2);
  const std::array<std::array<double, 2>, 5> nodes{
      {{475, blue}, {560, green}, {668, red}, {717, (red + infrared) / 2}, {842, infrared}}};
  if (wavelength_nm <= nodes.front()[0]) return nodes.front()[1];
  for (std::size_t i = 1; i < nodes.size(); ++i)
    if (wavelength_nm <= nodes[i][0]) {
      const double t = (wavelength_nm - nodes[i - 1][0]) / (nodes[i][0] - nodes[i - 1][0]);
      return nodes[i - 1][1] + (nodes[i][1] - nodes[i - 1][1]) * t;
    }
  return nodes.back()[1];
}

}  // namespace gpvc::synth
