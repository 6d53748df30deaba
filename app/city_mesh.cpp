#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "app/city.h"

namespace gpvc {
namespace {

constexpr double kGrid =
    1024;  // coordinates are multiples of 1/kGrid m: exact in float, and equal edges weld
constexpr double kBlockPitch_m = 36, kStreet_m = 8, kWalk_m = 2;

WorldPoint operator+(const WorldPoint& a, const WorldPoint& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
WorldPoint operator-(const WorldPoint& a, const WorldPoint& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
WorldPoint operator*(const WorldPoint& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double dot(const WorldPoint& a, const WorldPoint& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(const WorldPoint& a) { return std::sqrt(dot(a, a)); }
WorldPoint unit(const WorldPoint& a) { return a * (1 / length(a)); }

struct GridKey {
  std::int64_t x, y, z;
  bool operator==(const GridKey&) const = default;
};

struct GridHash {
  std::size_t operator()(const GridKey& k) const {
    return city_hash(static_cast<std::uint32_t>(k.x), static_cast<std::uint32_t>(k.y),
                     static_cast<std::uint32_t>(k.z));
  }
};

// Turns and moves what is built in a lot's own axes: x along the ridge, y across, z up.
struct Placement {
  WorldPoint origin;
  double cos = 1, sin = 0;
  WorldPoint turn(const WorldPoint& p) const { return {cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z}; }
  WorldPoint operator()(const WorldPoint& p) const { return origin + turn(p); }
};

class CityBuilder {
 public:
  CityBuilder(double edge_m, std::uint32_t seed) : edge_m_(edge_m), seed_(seed) {}

  City take() { return std::move(city_); }
  std::uint32_t chance_seed(std::uint32_t a, std::uint32_t b) const { return city_hash(seed_, a, b); }

  // A parallelogram seen from du x dv, in its own surface.
  std::uint32_t quad(Material material, const WorldPoint& p, const WorldPoint& du, const WorldPoint& dv,
                     bool windows = false) {
    const std::uint32_t surface = add_surface(material, p, du, dv);
    city_.surfaces[surface].windows = windows;
    const int nu = pieces(length(du)), nv = pieces(length(dv));
    std::vector<std::uint32_t> grid;
    for (int j = 0; j <= nv; ++j)
      for (int i = 0; i <= nu; ++i) {
        double a = i, b = j;
        if (i > 0 && i < nu && j > 0 && j < nv) {  // inside: no regular grid, photogrammetry makes none
          const auto n = static_cast<std::uint32_t>(j * (nu + 1) + i);
          a += 0.5 * (city_chance(city_.surfaces[surface].seed, n, 1) - 0.5);
          b += 0.5 * (city_chance(city_.surfaces[surface].seed, n, 2) - 0.5);
        }
        grid.push_back(vertex(p + du * (a / nu) + dv * (b / nv)));
      }
    for (int j = 0; j < nv; ++j)
      for (int i = 0; i < nu; ++i) {
        const auto at = [&](int x, int y) { return grid[static_cast<std::size_t>(y * (nu + 1) + x)]; };
        if ((i + j) % 2 == 0) {
          face(surface, at(i, j), at(i + 1, j), at(i + 1, j + 1));
          face(surface, at(i, j), at(i + 1, j + 1), at(i, j + 1));
        } else {
          face(surface, at(i, j), at(i + 1, j), at(i, j + 1));
          face(surface, at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        }
      }
    return surface;
  }
  void paint_like(std::uint32_t surface, std::uint32_t seed) { city_.surfaces[surface].seed = seed; }

  // A triangle a, b, c, counter-clockwise from outside.
  void triangle(Material material, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
    const WorldPoint ab = b - a, up{0, 0, 1};
    const std::uint32_t surface = add_surface(material, a, ab, up);
    const int n = pieces(std::max({length(ab), length(c - a), length(c - b)}));
    const auto at = [&](int i, int j) {  // i steps towards b, j towards c
      return vertex(a + ab * (static_cast<double>(i) / n) + (c - a) * (static_cast<double>(j) / n));
    };
    for (int j = 0; j < n; ++j)
      for (int i = 0; i + j < n; ++i) {
        face(surface, at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) face(surface, at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }

  // A box with corners lo and hi in the placement's axes, without its lower side unless `bottom`.
  void box(Material material, const Placement& place, const WorldPoint& lo, const WorldPoint& hi,
           bool bottom) {
    const WorldPoint d = hi - lo;
    const WorldPoint x = place.turn({d.x, 0, 0}), y = place.turn({0, d.y, 0}), z{0, 0, d.z};
    const auto corner = [&](bool cx, bool cy) { return place({cx ? hi.x : lo.x, cy ? hi.y : lo.y, lo.z}); };
    quad(material, corner(false, false), x, z);
    quad(material, corner(true, false), y, z);
    quad(material, corner(true, true), x * -1, z);
    quad(material, corner(false, true), y * -1, z);
    quad(material, corner(false, false) + z, x, y);
    if (bottom) quad(material, corner(false, true), x, y * -1);
  }

  // A lumpy ball of leaves: an icosahedron, split and pushed out by chance.
  void ball(const WorldPoint& centre, double radius_m, std::uint32_t seed);
  void trunk(const WorldPoint& foot, double height_m, double radius_m);

 private:
  int pieces(double length_m) const { return std::max(1, static_cast<int>(std::ceil(length_m / edge_m_))); }

  std::uint32_t add_surface(Material material, const WorldPoint& p, const WorldPoint& du,
                            const WorldPoint& dv) {
    const auto id = static_cast<std::uint32_t>(city_.surfaces.size());
    const WorldPoint u = unit(du);
    const WorldPoint v = unit(dv - u * dot(u, dv));
    city_.surfaces.push_back({material, p, u, v, city_hash(seed_, id, 77), false});
    return id;
  }

  std::uint32_t vertex(const WorldPoint& p) {
    const GridKey key{std::llround(p.x * kGrid), std::llround(p.y * kGrid), std::llround(p.z * kGrid)};
    const auto [at, fresh] =
        vertices_.try_emplace(key, static_cast<std::uint32_t>(city_.mesh.positions.size()));
    if (fresh)
      city_.mesh.positions.push_back({static_cast<double>(key.x) / kGrid, static_cast<double>(key.y) / kGrid,
                                      static_cast<double>(key.z) / kGrid});
    return at->second;
  }

  void face(std::uint32_t surface, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a == b || b == c || c == a) return;  // a piece below the grid
    city_.mesh.faces.push_back({a, b, c});
    city_.face_surface.push_back(surface);
  }

  double edge_m_;
  std::uint32_t seed_;
  City city_;
  std::unordered_map<GridKey, std::uint32_t, GridHash> vertices_;
};

void CityBuilder::ball(const WorldPoint& centre, double radius_m, std::uint32_t seed) {
  const std::uint32_t surface = add_surface(Material::leaves, centre, {1, 0, 0}, {0, 1, 0});
  const double g = (1 + std::sqrt(5.0)) / 2;
  const std::array<WorldPoint, 12> corners{{{-1, g, 0},
                                            {1, g, 0},
                                            {-1, -g, 0},
                                            {1, -g, 0},
                                            {0, -1, g},
                                            {0, 1, g},
                                            {0, -1, -g},
                                            {0, 1, -g},
                                            {g, 0, -1},
                                            {g, 0, 1},
                                            {-g, 0, -1},
                                            {-g, 0, 1}}};
  constexpr int kSides[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  const int n = std::max(2, static_cast<int>(std::ceil(radius_m / edge_m_ * 1.5)));
  const auto push_out = [&](const WorldPoint& direction) {
    const WorldPoint d = unit(direction);
    // Lumps of about a third of the radius; the key is coarse, so that neighbouring sides agree on shared
    // corners.
    const auto coarse = [](double v) { return static_cast<std::uint32_t>(std::llround(v * 4096)); };
    const double lump = 0.86 + 0.28 * city_chance(seed ^ coarse(d.x), coarse(d.y), coarse(d.z));
    return vertex(centre + d * (radius_m * lump));
  };
  for (const auto& side : kSides) {
    const WorldPoint& a = corners[static_cast<std::size_t>(side[0])];
    const WorldPoint ab = corners[static_cast<std::size_t>(side[1])] - a;
    const WorldPoint ac = corners[static_cast<std::size_t>(side[2])] - a;
    const auto at = [&](int i, int j) { return push_out(a + ab * (1.0 * i / n) + ac * (1.0 * j / n)); };
    for (int j = 0; j < n; ++j)
      for (int i = 0; i + j < n; ++i) {
        face(surface, at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) face(surface, at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }
}

void CityBuilder::trunk(const WorldPoint& foot, double height_m, double radius_m) {
  const double d = radius_m * 0.70710678118654752;
  const std::array<std::array<double, 2>, 8> ring{
      {{radius_m, 0}, {d, d}, {0, radius_m}, {-d, d}, {-radius_m, 0}, {-d, -d}, {0, -radius_m}, {d, -d}}};
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const auto &a = ring[i], &b = ring[(i + 1) % ring.size()];
    quad(Material::bark, foot + WorldPoint{a[0], a[1], 0}, {b[0] - a[0], b[1] - a[1], 0}, {0, 0, height_m});
    triangle(Material::bark, foot + WorldPoint{0, 0, height_m}, foot + WorldPoint{a[0], a[1], height_m},
             foot + WorldPoint{b[0], b[1], height_m});
  }
}

struct Building {
  Placement place;          // origin: the middle of the footprint, on the ground
  double width_m, depth_m;  // along x (the ridge), along y
  double height_m;          // of the walls
  Material walls;
};

void add_balconies(CityBuilder& builder, const Building& b, std::uint32_t seed) {
  constexpr double kFloor_m = 3, kBay_m = 5, kDepth_m = 1.3, kSlab_m = 0.2, kRail_m = 1.0, kThin_m = 0.1;
  constexpr double kIntoWall_m = 0.1;  // slabs end inside the wall: no two coplanar faces
  for (int side = -1; side <= 1; side += 2)
    for (int floor = 1; (floor + 1) * kFloor_m <= b.height_m; ++floor)
      for (int bay = 0; (bay + 1) * kBay_m <= b.width_m; ++bay) {
        const auto n = static_cast<std::uint32_t>(floor * 64 + bay);
        if (city_chance(seed, n, static_cast<std::uint32_t>(side + 1)) < 0.4) continue;
        const double x0 = -b.width_m / 2 + bay * kBay_m + 1.2, x1 = x0 + 2.6, z = floor * kFloor_m;
        const double wall = side * b.depth_m / 2, inner = wall - side * kIntoWall_m,
                     outer = wall + side * kDepth_m;
        builder.box(Material::concrete, b.place, {x0, std::min(inner, outer), z},
                    {x1, std::max(inner, outer), z + kSlab_m}, true);
        const double rail = outer - side * kThin_m;
        builder.box(Material::concrete, b.place, {x0, std::min(rail, outer), z + kSlab_m},
                    {x1, std::max(rail, outer), z + kSlab_m + kRail_m}, false);
      }
}

void add_walls(CityBuilder& builder, const Building& b, double height_m) {
  const double w = b.width_m, d = b.depth_m;
  const WorldPoint up{0, 0, height_m};
  builder.quad(b.walls, b.place({-w / 2, -d / 2, 0}), b.place.turn({w, 0, 0}), up, true);
  builder.quad(b.walls, b.place({w / 2, -d / 2, 0}), b.place.turn({0, d, 0}), up, true);
  builder.quad(b.walls, b.place({w / 2, d / 2, 0}), b.place.turn({-w, 0, 0}), up, true);
  builder.quad(b.walls, b.place({-w / 2, d / 2, 0}), b.place.turn({0, -d, 0}), up, true);
}

// Two slabs that overhang the walls on all sides; walls and gables end inside the slabs.
void add_gable_roof(CityBuilder& builder, const Building& b, std::uint32_t seed) {
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
    builder.paint_like(builder.quad(Material::tiles, eaves, u, v), seed);
    builder.quad(Material::concrete, eaves + thick + v, u, v * -1);           // soffit
    builder.quad(Material::concrete, eaves + thick, u, thick * -1);           // fascia
    builder.quad(Material::concrete, eaves + thick + v, v * -1, thick * -1);  // verges
    builder.quad(Material::concrete, eaves + u + thick, v, thick * -1);
  }
  const double cx = (city_chance(seed, 5) - 0.5) * w * 0.6;
  builder.box(Material::brick, b.place, {cx - 0.5, 0.8, b.height_m + 0.5}, {cx + 0.5, 1.8, ridge + 1.0},
              false);
}

void add_flat_roof(CityBuilder& builder, const Building& b, std::uint32_t seed) {
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
  const double x = (city_chance(seed, 6) - 0.5) * iw * 0.5;
  builder.box(Material::concrete, b.place, {x - 1.5, -1, b.height_m - 0.1}, {x + 1.5, 1.2, b.height_m + 1.6},
              false);
}

void add_building(CityBuilder& builder, const WorldPoint& middle, std::uint32_t seed) {
  // Turned by exact Pythagorean angles.
  constexpr double kTurns[4][2] = {
      {1, 0}, {12.0 / 13, 5.0 / 13}, {40.0 / 41, -9.0 / 41}, {24.0 / 25, 7.0 / 25}};
  const auto& turn = kTurns[city_hash(seed, 1) % 4];
  Building b;
  b.place = {middle, turn[0], turn[1]};
  b.width_m = 12 + 2 * (city_hash(seed, 2) % 3);
  b.depth_m = 8 + city_hash(seed, 3) % 3;
  b.height_m = 6 + 3 * (city_hash(seed, 4) % 4);
  b.walls = city_hash(seed, 7) % 2 == 0 ? Material::plaster : Material::brick;
  if (city_hash(seed, 8) % 3 == 0)
    add_flat_roof(builder, b, seed);
  else
    add_gable_roof(builder, b, seed);
  add_balconies(builder, b, seed);
}

void add_tree(CityBuilder& builder, const WorldPoint& foot, std::uint32_t seed) {
  const double trunk = 2.2 + city_chance(seed, 1), radius = 1.5 + 1.1 * city_chance(seed, 2);
  builder.trunk(foot, trunk, 0.25);
  // The crown floats: its lowest leaf is 0.1 m or more above the trunk, as where thin branches are not in a
  // mesh.
  builder.ball(foot + WorldPoint{0, 0, trunk + 1.14 * radius + 0.1}, radius, seed);
}

City build(const CityOptions& options, double edge_m) {
  CityBuilder builder(edge_m, options.seed);
  const double half = options.size_m / 2;
  builder.quad(Material::ground, {-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0});
  const int reach = static_cast<int>((half - (kBlockPitch_m - kStreet_m) / 2) / kBlockPitch_m);
  for (int by = -reach; by <= reach; ++by)
    for (int bx = -reach; bx <= reach; ++bx) {
      const std::uint32_t seed =
          builder.chance_seed(static_cast<std::uint32_t>(bx + 1000), static_cast<std::uint32_t>(by + 1000));
      const WorldPoint block{bx * kBlockPitch_m, by * kBlockPitch_m, 0};
      add_building(builder, block + WorldPoint{0, -6.5, 0}, city_hash(seed, 1));
      if (city_hash(seed, 2) % 4 != 0)
        add_building(builder, block + WorldPoint{0, 6.5, 0}, city_hash(seed, 3));
      const double kerb = kBlockPitch_m / 2 - kStreet_m / 2 - kWalk_m / 2;
      for (int side = 0; side < 4; ++side)
        for (int n = 0; n < 4; ++n) {
          const std::uint32_t tree =
              city_hash(seed, static_cast<std::uint32_t>(side), static_cast<std::uint32_t>(n));
          if (tree % 3 == 0) continue;
          const double along = (n - 1.5) * 6.5 + 2 * (city_chance(tree, 9) - 0.5);
          const double across = side < 2 ? -kerb : kerb;
          const WorldPoint at = side % 2 == 0 ? WorldPoint{along, across, 0} : WorldPoint{across, along, 0};
          const WorldPoint foot = block + at;
          if (std::max(std::abs(foot.x), std::abs(foot.y)) > half - 3) continue;
          add_tree(builder, foot, tree);
        }
    }
  return builder.take();
}

}  // namespace

City make_city(const CityOptions& options) {
  // The number of faces falls as the edge grows: bisect.
  double fine = 0.02, coarse = 50;
  City best = build(options, coarse);
  for (int step = 0; step < 18 && fine * 1.01 < coarse; ++step) {
    const double middle = std::sqrt(fine * coarse);
    // A city of far too many faces is not built to be thrown away: the area bounds their number from below.
    if (2 * options.size_m * options.size_m / (middle * middle) > 2.0 * static_cast<double>(options.faces)) {
      fine = middle;
      continue;
    }
    City city = build(options, middle);
    const auto miss = [&](const City& c) {
      return std::abs(static_cast<double>(c.mesh.faces.size()) - static_cast<double>(options.faces));
    };
    (city.mesh.faces.size() > options.faces ? fine : coarse) = middle;
    if (miss(city) < miss(best)) best = std::move(city);
  }
  return best;
}

}  // namespace gpvc
