// Scenes that visibility is tested on, made in code.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "io/scene.h"

namespace gpvc::scenes {

/// A camera looking along +z from the origin, one pixel a unit at depth f.
inline View view_of(int width, int height, double f, double cx, double cy) {
  View view;
  view.name = "view";
  view.camera = {width, height, f, f, cx, cy, {}};
  return view;
}

inline View view_of(int width, int height, double f) {
  return view_of(width, height, f, width / 2.0, height / 2.0);
}

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
inline void add_at_pixels(Mesh& mesh, const Camera& camera,
                          const std::array<std::array<double, 3>, 3>& corners) {
  add_face(mesh, at_pixel(camera, corners[0][0], corners[0][1], corners[0][2]),
           at_pixel(camera, corners[1][0], corners[1][1], corners[1][2]),
           at_pixel(camera, corners[2][0], corners[2][1], corners[2][2]));
}

/// Unconnected triangles of about `size_px` pixels all over the frame and beyond its borders, facing
/// anywhere, at depths 5 to 15.
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

}  // namespace gpvc::scenes
