// A synthetic UAV scene of known truth: a few city blocks, a deterministic flight, photos traced with Embree
// (which shares no code with the visibility stage it serves to test). Bits do not depend on the machine or
// the threads: +, -, x, /, sqrt and integer hashes alone, no libm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/io.h"
#include "io/scene.h"

namespace gpvc {

struct CityOptions {
  std::size_t faces = 60000;  ///< aimed at; the tessellation is chosen to come near
  int photos = 20;            ///< a fifth nadir, the rest oblique from four sides
  int width = 1200, height = 800;
  double size_m = 100;  ///< edge of the square ground, metres
  std::uint32_t seed = 1;
  bool distorted = true;  ///< lens distortion and an off-centre principal point
};

enum class Material : std::uint8_t { ground, plaster, brick, tiles, gravel, concrete, bark, leaves };

/// A plane (or a crown) with its own albedo: procedural in (u, v) = ((p - origin) . u_axis, (p - origin) .
/// v_axis).
struct Surface {
  Material material = Material::ground;
  WorldPoint origin;
  WorldPoint u_axis, v_axis;  ///< unit length
  std::uint32_t seed = 0;
  bool windows = false;
};

struct City {
  Mesh mesh;                                ///< z up, metres; every coordinate a multiple of 2^-10
  std::vector<std::uint32_t> face_surface;  ///< per face, index into surfaces
  std::vector<Surface> surfaces;            ///< surfaces[0] is the ground
};

using Colour = std::array<double, 3>;  ///< display values, 0..255

/// O(faces).
City make_city(const CityOptions& options);

/// Views in the order of their names, without photo paths.
std::vector<View> city_flight(const CityOptions& options);

/// The colour of a surface point before light falls on it.
Colour city_albedo(const Surface& surface, const WorldPoint& p);

/// Light, shadow and camera for a city. Holds an Embree scene.
class CityRenderer {
 public:
  explicit CityRenderer(const City& city);
  ~CityRenderer();
  CityRenderer(const CityRenderer&) = delete;
  CityRenderer& operator=(const CityRenderer&) = delete;

  /// What the camera takes, 2 x 2 samples a pixel, through its lens distortion. Uses all TBB threads.
  Image photo(const Camera& camera, const Pose& pose);
  /// True when nothing lies between `p` and the camera centre.
  bool sees(const Pose& pose, const WorldPoint& p) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Binary little-endian PLY, float coordinates (exact for a city's mesh).
void write_city_mesh(const std::filesystem::path& file, const Mesh& mesh);

/// COLMAP text model: cameras.txt, images.txt, and points3D.txt with some surface points and the views that
/// see them.
void write_city_cameras(const std::filesystem::path& dir, const City& city, const std::vector<View>& views,
                        const CityRenderer& renderer);

/// surfaces.json: material, frame and seed per surface.
void write_city_surfaces(const std::filesystem::path& file, const City& city);

/// A hash of integers, the only source of chance in a city.
constexpr std::uint32_t city_hash(std::uint32_t a, std::uint32_t b = 0, std::uint32_t c = 0) {
  std::uint32_t h = a * 0x9E3779B1u ^ (b * 0x85EBCA77u + 0x165667B1u) ^ (c * 0xC2B2AE3Du + 0x27D4EB2Fu);
  h ^= h >> 16;
  h *= 0x7FEB352Du;
  h ^= h >> 15;
  h *= 0x846CA68Bu;
  h ^= h >> 16;
  return h;
}

/// [0, 1), a multiple of 2^-24.
constexpr double city_chance(std::uint32_t a, std::uint32_t b = 0, std::uint32_t c = 0) {
  return static_cast<double>(city_hash(a, b, c) >> 8) * (1.0 / 16777216.0);
}

}  // namespace gpvc
