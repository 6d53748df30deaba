// Scenes that visibility is tested on, made in code.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "io/scene.h"

namespace gpvc::scenes {

/// A camera looking along +z from the origin, one pixel a unit at depth f.
inline View view_of(int width, int height, double f, double cx, double cy) {
  View view;
  view.name = "view";
  view.camera = {width, height, f, f, cx, cy, {}};
  return view;
}

inline View view_of(int width, int height, double f) { return view_of(width, height, f, width / 2.0, height / 2.0); }

/// Rotations about x, then y, then z, in radians.
inline std::array<double, 9> rotation(double x, double y, double z) {
  const double cx = std::cos(x), sx = std::sin(x), cy = std::cos(y), sy = std::sin(y), cz = std::cos(z),
               sz = std::sin(z);
  return {cz * cy,
          cz * sy * sx - sz * cx,
          cz * sy * cx + sz * sx,
          sz * cy,
          sz * sy * sx + cz * cx,
          sz * sy * cx - cz * sx,
          -sy,
          cy * sx,
          cy * cx};
}

inline void add_face(Mesh& mesh, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.faces.push_back({first, first + 1, first + 2});
}

/// The world point that view_of(...) with an identity pose sees at pixel (x, y) and depth z.
inline WorldPoint at_pixel(const Camera& camera, double x, double y, double z) {
  return {(x - camera.cx) / camera.fx * z, (y - camera.cy) / camera.fy * z, z};
}

/// A triangle with corners at pixels, each with a depth; counter-clockwise on the screen is front-facing.
inline void add_at_pixels(Mesh& mesh, const Camera& camera, const std::array<std::array<double, 3>, 3>& corners) {
  add_face(mesh, at_pixel(camera, corners[0][0], corners[0][1], corners[0][2]),
           at_pixel(camera, corners[1][0], corners[1][1], corners[1][2]),
           at_pixel(camera, corners[2][0], corners[2][1], corners[2][2]));
}

/// Unconnected triangles of about `size_px` pixels all over the frame and beyond its borders, facing anywhere, at
/// depths 5 to 15.
inline Mesh soup(const Camera& camera, std::size_t faces, double size_px, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  Mesh mesh;
  for (std::size_t f = 0; f < faces; ++f) {
    const double x = uniform(-0.1, 1.1) * camera.width, y = uniform(-0.1, 1.1) * camera.height;
    const double z = uniform(5, 15);
    std::array<std::array<double, 3>, 3> corners{};
    for (auto& corner : corners)
      corner = {x + uniform(-size_px, size_px), y + uniform(-size_px, size_px),
                z + uniform(-1, 1) * size_px / camera.fx * z};
    add_at_pixels(mesh, camera, corners);
  }
  return mesh;
}

/// A height field of columns x rows cells of two front faces each, seen from above by a camera at (0, 0, 0) that looks
/// along +z; `depth(i, j)` of each corner. Vertices are shared.
template <class Depth>
Mesh terrain(const Camera& camera, int columns, int rows, double x0, double y0, double cell_px, double scale_depth,
             Depth&& depth) {
  Mesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      WorldPoint p = at_pixel(camera, x0 + i * cell_px, y0 + j * cell_px, scale_depth);
      p.z = depth(i, j);
      mesh.positions.push_back(p);
    }
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      mesh.faces.push_back({id(i, j), id(i, j + 1), id(i + 1, j)});
      mesh.faces.push_back({id(i + 1, j), id(i, j + 1), id(i + 1, j + 1)});
    }
  return mesh;
}

inline void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.faces) mesh.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
}

/// Two uneven terrain layers of 2 cells^2 faces each, the lower one `gap_m` below the upper, seen from `distance_m`
/// above. The upper layer is perforated: its triangles are shrunk towards their centroids, so that gaps run all around
/// them. A triangle of the lower layer is larger than the perforated ones and wider than the gaps: it is neither wholly
/// hidden nor wholly seen, whatever the parallax.
inline Mesh layers(const Camera& camera, double distance_m, double gap_m, int cells) {
  constexpr double kShrink = 0.7;
  const double relief = 8 * (distance_m / 6100);
  std::mt19937 random(4802);
  std::vector<double> heights;
  for (int i = 0; i < (cells + 1) * (cells + 1); ++i)
    heights.push_back(distance_m + relief * (static_cast<double>(random()) / 4294967296.0 - 0.5));
  const double cell = 0.9 * camera.width / cells;
  const auto height = [&](int i, int j) { return heights[static_cast<std::size_t>(j * (cells + 1) + i)]; };
  const Mesh whole = terrain(camera, cells, cells, 0.05 * camera.width, 0.05 * camera.height, cell, distance_m, height);
  Mesh mesh;
  for (const Triangle& t : whole.faces) {
    const WorldPoint &a = whole.positions[t[0]], &b = whole.positions[t[1]], &c = whole.positions[t[2]];
    const WorldPoint g{(a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3, (a.z + b.z + c.z) / 3};
    const auto shrunk = [&](const WorldPoint& p) {
      return WorldPoint{g.x + kShrink * (p.x - g.x), g.y + kShrink * (p.y - g.y), g.z + kShrink * (p.z - g.z)};
    };
    add_face(mesh, shrunk(a), shrunk(b), shrunk(c));
  }
  Mesh lower = whole;
  for (WorldPoint& p : lower.positions) p.z += gap_m;
  append(mesh, lower);
  return mesh;
}

/// The paper's synthetic models A, B, C: two layers of 4802 faces, the viewpoint 6100 m above.
inline Mesh two_layers(const Camera& camera, double gap_m) { return layers(camera, 6100, gap_m, 49); }

}  // namespace gpvc::scenes
