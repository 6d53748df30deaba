#include "app/synth/synth_builder.h"

#include <algorithm>

namespace gpvc::synth {

std::uint32_t SynthBuilder::add_surface(Material material, const WorldPoint& p, const WorldPoint& du,
                                        const WorldPoint& dv) {
  const auto id = static_cast<std::uint32_t>(scene_.surfaces.size());
  const WorldPoint u = unit(du);
  const WorldPoint v = unit(dv - u * dot(u, dv));
  Surface surface{material, p, u, v, synth_hash(seed_, id, 77)};
  // Surfaces that meet or hide one another must differ in colour.
  for (std::uint32_t c = 0; c < 3 && id > 0; ++c) surface.tint[c] = 0.7 + 0.6 * synth_chance(surface.seed, 500 + c);
  scene_.surfaces.push_back(surface);
  return id;
}

std::uint32_t SynthBuilder::vertex(const WorldPoint& p) {
  const Key key{std::llround(p.x * grid_per_m_), std::llround(p.y * grid_per_m_), std::llround(p.z * grid_per_m_)};
  const auto [at, fresh] = vertices_.try_emplace(key, static_cast<std::uint32_t>(scene_.mesh.positions.size()));
  if (fresh)
    scene_.mesh.positions.push_back({static_cast<double>(key.x) / grid_per_m_, static_cast<double>(key.y) / grid_per_m_,
                                     static_cast<double>(key.z) / grid_per_m_});
  return at->second;
}

void SynthBuilder::face(std::uint32_t surface, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (a == b || b == c || c == a) return;  // smaller than the grid
  scene_.mesh.faces.push_back({a, b, c});
  scene_.face_surface.push_back(surface);
}

void SynthBuilder::cells(std::uint32_t surface, const std::vector<std::uint32_t>& grid, int nu, int nv, bool odd) {
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const auto at = [&](int x, int y) { return grid[static_cast<std::size_t>(y * (nu + 1) + x)]; };
      if (((i + j) % 2 != 0) == odd) {
        face(surface, at(i, j), at(i + 1, j), at(i + 1, j + 1));
        face(surface, at(i, j), at(i + 1, j + 1), at(i, j + 1));
      } else {
        face(surface, at(i, j), at(i + 1, j), at(i, j + 1));
        face(surface, at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
}

template <class VertexAt>
void SynthBuilder::triangular_cells(std::uint32_t surface, int n, VertexAt at) {
  for (int j = 0; j < n; ++j)
    for (int i = 0; i + j < n; ++i) {
      face(surface, at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + j + 1 < n) face(surface, at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
}

std::uint32_t SynthBuilder::quad(Material material, const WorldPoint& p, const WorldPoint& du, const WorldPoint& dv,
                                 bool windows) {
  const std::uint32_t surface = add_surface(material, p, du, dv);
  scene_.surfaces[surface].windows = windows;
  const int nu = pieces(length(du)), nv = pieces(length(dv));
  counted_ += 2 * static_cast<std::size_t>(nu) * static_cast<std::size_t>(nv);
  if (count_only_) return surface;
  std::vector<std::uint32_t> grid;
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i) {
      double a = i, b = j;
      if (i > 0 && i < nu && j > 0 && j < nv) {  // irregular inside, as meshes from photogrammetry are
        const auto n = static_cast<std::uint32_t>(j * (nu + 1) + i);
        a += 0.5 * (synth_chance(scene_.surfaces[surface].seed, n, 1) - 0.5);
        b += 0.5 * (synth_chance(scene_.surfaces[surface].seed, n, 2) - 0.5);
      }
      grid.push_back(vertex(p + du * (a / nu) + dv * (b / nv)));
    }
  cells(surface, grid, nu, nv);
  return surface;
}

void SynthBuilder::triangle(Material material, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  const WorldPoint ab = b - a, up{0, 0, 1};
  const std::uint32_t surface = add_surface(material, a, ab, up);
  const int n = pieces(std::max({length(ab), length(c - a), length(c - b)}));
  counted_ += static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  if (count_only_) return;
  const auto at = [&](int i, int j) {  // i steps towards b, j towards c
    return vertex(a + ab * (static_cast<double>(i) / n) + (c - a) * (static_cast<double>(j) / n));
  };
  triangular_cells(surface, n, at);
}

void SynthBuilder::box(Material material, const Placement& place, const WorldPoint& lo, const WorldPoint& hi,
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

std::optional<std::uint32_t> SynthBuilder::relief(Material material, const WorldPoint& lo, const WorldPoint& hi,
                                                  const WorldPoint& from, const WorldPoint& to,
                                                  const std::function<double(double x, double y)>& height) {
  const int nu = pieces(hi.x - lo.x), nv = pieces(hi.y - lo.y);
  const auto lines = [](double low, double high, double begin, double end, int n) {
    return std::pair{static_cast<int>(std::ceil((begin - low) / (high - low) * n)),
                     static_cast<int>(std::floor((end - low) / (high - low) * n))};
  };
  const auto [i0, i1] = lines(lo.x, hi.x, from.x, to.x, nu);
  const auto [j0, j1] = lines(lo.y, hi.y, from.y, to.y, nv);
  if (i1 <= i0 || j1 <= j0) return std::nullopt;
  const std::uint32_t surface = add_surface(material, from, {1, 0, 0}, {0, 1, 0});
  counted_ += 2 * static_cast<std::size_t>(i1 - i0) * static_cast<std::size_t>(j1 - j0);
  if (count_only_) return surface;
  std::vector<std::uint32_t> grid;
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      const double x = lo.x + (hi.x - lo.x) * i / nu, y = lo.y + (hi.y - lo.y) * j / nv;
      grid.push_back(vertex({x, y, height(x, y)}));
    }
  cells(surface, grid, i1 - i0, j1 - j0, (i0 + j0) % 2 != 0);
  return surface;
}

void SynthBuilder::ball(const WorldPoint& centre, double radius_m, std::uint32_t seed) {
  const std::uint32_t surface = add_surface(Material::leaves, centre, {1, 0, 0}, {0, 1, 0});
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::array<WorldPoint, 12> corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const double s = k % 2 == 0 ? -1 : 1, t = k < 2 ? g : -g;
    corners[k] = {s, t, 0};
    corners[4 + k] = {0, s, t};
    corners[8 + k] = {t, 0, s};
  }
  constexpr int kSides[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  const int n = std::max(2, static_cast<int>(std::ceil(radius_m / edge_m_ * 1.5)));
  counted_ += 20 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  if (count_only_) return;
  const auto push_out = [&](const WorldPoint& direction) {
    const WorldPoint d = unit(direction);
    // Lumps of about a third of the radius. The direction is rounded for the hash, so that neighbouring sides of the
    // icosahedron agree on shared vertices.
    const auto coarse = [](double v) { return static_cast<std::uint32_t>(std::llround(v * 4096)); };
    const double lump = 0.86 + 0.28 * synth_chance(seed ^ coarse(d.x), coarse(d.y), coarse(d.z));
    return vertex(centre + d * (radius_m * lump));
  };
  for (const auto& side : kSides) {
    const WorldPoint& a = corners[static_cast<std::size_t>(side[0])];
    const WorldPoint ab = corners[static_cast<std::size_t>(side[1])] - a;
    const WorldPoint ac = corners[static_cast<std::size_t>(side[2])] - a;
    const auto at = [&](int i, int j) { return push_out(a + ab * (1.0 * i / n) + ac * (1.0 * j / n)); };
    triangular_cells(surface, n, at);
  }
}

void SynthBuilder::trunk(const WorldPoint& foot, double height_m, double radius_m) {
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

SynthScene build_scene(std::size_t faces, EdgeSearch search, double grid_per_m, std::uint32_t seed,
                       const std::function<void(SynthBuilder&)>& build) {
  double best_m = search.coarse_m;
  std::size_t best_miss = SIZE_MAX;
  for (int step = 0; step < 24 && search.fine_m * search.precision < search.coarse_m; ++step) {
    const double middle_m = std::sqrt(search.fine_m * search.coarse_m);
    SynthBuilder counter(middle_m, grid_per_m, seed, true);
    build(counter);
    const std::size_t made = counter.faces(), miss = made > faces ? made - faces : faces - made;
    (made > faces ? search.fine_m : search.coarse_m) = middle_m;
    if (miss >= best_miss) continue;
    best_miss = miss;
    best_m = middle_m;
  }
  SynthBuilder builder(best_m, grid_per_m, seed);
  build(builder);
  return builder.take();
}

}  // namespace gpvc::synth
