// Synthetic scenes of known truth: a mesh whose every face belongs to a surface with an albedo of its own, and photos
// of it traced with Embree, which shares no code with the visibility stage it serves to test. Bits do not depend on the
// machine or the threads: +, -, x, /, sqrt and integer hashes alone, no libm.
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

namespace gpvc::synth {

enum class Material : std::uint8_t {
  ground,
  plaster,
  brick,
  tiles,
  gravel,
  concrete,
  bark,
  leaves,
  metal,
  paint,
  meadow
};

using Color = std::array<double, 3>;  ///< display values, 0..255

/// A plane (or a crown, a hillside) with its own albedo: procedural in (u, v) = ((p - origin) . u_axis, (p - origin) .
/// v_axis).
struct Surface {
  Material material = Material::ground;
  WorldPoint origin;
  WorldPoint u_axis, v_axis;  ///< unit length
  std::uint32_t seed = 0;
  bool windows = false;
  Color tint{1, 1, 1};  ///< factor on the albedo: surfaces that meet in photos can be told apart
  double scale = 1;     ///< metres that a metre of the pattern covers
};

struct SynthScene {
  Mesh mesh;                                ///< z up, metres; every coordinate exact in float
  std::vector<std::uint32_t> face_surface;  ///< per face, index into surfaces
  std::vector<Surface> surfaces;            ///< surfaces[0] is the ground
  bool endless_ground = false;              ///< photos show the ground of surfaces[0], z = 0, beyond the mesh too
};

/// The colour of a surface point before light falls on it.
Color surface_albedo(const Surface& surface, const WorldPoint& p);

/// A camera's own exposure: colours are multiplied by `gain` and fall off towards the corners by `vignetting`.
struct Exposure {
  double gain = 1, vignetting = 0;
  /// At the squared distance from the middle of the picture, 1 in the corners.
  double at(double corner_share) const { return gain * (1 - vignetting * corner_share); }
};

/// Pixels of an id picture whose samples see several surfaces.
inline constexpr std::uint32_t kMixedSurfaces = 0xFFFFFFFEu;
/// Pixels that see the sky or nothing.
inline constexpr std::uint32_t kNoSurface = 0xFFFFFFFFu;

struct SynthPhoto {
  Image image;
  /// Per pixel the surface that all its samples see, kMixedSurfaces or kNoSurface; moving things have numbers from the
  /// scene's surfaces on.
  std::vector<std::uint32_t> surfaces;
};

/// Light, shadow and camera for a scene. Holds an Embree scene.
class SynthRenderer {
 public:
  explicit SynthRenderer(const SynthScene& scene);
  ~SynthRenderer();
  SynthRenderer(const SynthRenderer&) = delete;
  SynthRenderer& operator=(const SynthRenderer&) = delete;

  /// What the camera takes, 2 x 2 samples a pixel, through its lens distortion. Uses all TBB threads. `moving`: what is
  /// there in this photo alone.
  SynthPhoto photo(const Camera& camera, const Pose& pose, const Exposure& exposure = {},
                   const SynthScene* moving = nullptr);
  /// True when nothing lies between a point of face `face` and the camera centre: the first face that the ray from the
  /// centre meets is that one, or no nearer than it in double precision.
  bool sees(const Pose& pose, const WorldPoint& p, std::uint32_t face) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Binary little-endian PLY, coordinates plus `offset`; float where that is exact, else double.
void write_synth_mesh(const std::filesystem::path& file, const Mesh& mesh, const WorldPoint& offset);

/// COLMAP text model: cameras.txt, images.txt, and points3D.txt with some surface points and the views that see them.
/// Positions and camera centres are moved by `offset`.
void write_synth_cameras(const std::filesystem::path& dir, const SynthScene& scene, const std::vector<View>& views,
                         const SynthRenderer& renderer, const WorldPoint& offset);

/// surfaces.json: material, frame, seed, tint and scale per surface.
void write_synth_surfaces(const std::filesystem::path& file, const SynthScene& scene);

/// A hash of integers, the only source of chance in a scene.
constexpr std::uint32_t synth_hash(std::uint32_t a, std::uint32_t b = 0, std::uint32_t c = 0) {
  std::uint32_t h = a * 0x9E3779B1u ^ (b * 0x85EBCA77u + 0x165667B1u) ^ (c * 0xC2B2AE3Du + 0x27D4EB2Fu);
  h ^= h >> 16;
  h *= 0x7FEB352Du;
  h ^= h >> 15;
  h *= 0x846CA68Bu;
  h ^= h >> 16;
  return h;
}

/// [0, 1), a multiple of 2^-24.
constexpr double synth_chance(std::uint32_t a, std::uint32_t b = 0, std::uint32_t c = 0) {
  return static_cast<double>(synth_hash(a, b, c) >> 8) * (1.0 / 16777216.0);
}

/// Value noise on the unit lattice, [0, 1], smooth between lattice points.
double synth_noise(double x, double y, std::uint32_t seed);

}  // namespace gpvc::synth
