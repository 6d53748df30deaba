// Synthetic scenes of known truth: a mesh whose every face belongs to a surface with an albedo of its own, and photos
// of it traced with Embree, which shares no code with the visibility stage that it serves to test. The same bits on every
// machine and with any number of threads: only +, -, x, /, sqrt and integer hashes are used, nothing else of libm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/synth/shot.h"
#include "io/image.h"
#include "io/names.h"
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
inline constexpr Named<Material> kMaterialNames[] = {
    {"ground", Material::ground}, {"plaster", Material::plaster}, {"brick", Material::brick},
    {"tiles", Material::tiles},   {"gravel", Material::gravel},   {"concrete", Material::concrete},
    {"bark", Material::bark},     {"leaves", Material::leaves},   {"metal", Material::metal},
    {"paint", Material::paint},   {"meadow", Material::meadow}};

using Color = std::array<double, 3>;  ///< display values, 0..255

/// A plane, a crown or a hillside with an albedo of its own, which is a function of u = (p - origin) . u_axis and
/// v = (p - origin) . v_axis.
struct Surface {
  Material material = Material::ground;
  WorldPoint origin;
  WorldPoint u_axis, v_axis;  ///< unit length
  std::uint32_t seed = 0;
  bool windows = false;
  Color tint{1, 1, 1};  ///< factor on the albedo, by which surfaces that meet in photos differ
  double scale = 1;     ///< metres that a metre of the pattern covers
};

struct SynthScene {
  Mesh mesh;                                ///< z up, metres; every coordinate exact in float
  std::vector<std::uint32_t> face_surface;  ///< per face, index into surfaces
  std::vector<Surface> surfaces;            ///< surfaces[0] is the ground
  bool endless_ground = false;              ///< photos show surfaces[0] at z = 0 beyond the mesh, too
};

/// True if the point of the surface lies in the glass of a window.
bool in_window_pane(const Surface& surface, const WorldPoint& p);
/// Albedo at a point of the surface, with the surface's tint.
Color surface_albedo(const Surface& surface, const WorldPoint& p);

/// The share of the light that a point of the surface reflects at a wavelength. At 475, 560 and 668 nm it is the albedo's blue, green and
/// red over 255; at 842 nm the red one times a factor of the material, 0.8 to 1.2, and 1.2 times what green has over the mean of
/// red and blue, as leaves have; at 717 nm halfway between red and that; linear between these, and constant beyond.
double surface_reflectance(const Surface& surface, const WorldPoint& p, double wavelength_nm);

/// Marks pixels whose samples see several surfaces.
inline constexpr std::uint32_t kMixedSurfaces = 0xFFFFFFFEu;
/// Marks pixels that see the sky or nothing.
inline constexpr std::uint32_t kNoSurface = 0xFFFFFFFFu;

struct SynthPhoto {
  Image image;
  /// Per pixel the surface that all its samples see, kMixedSurfaces or kNoSurface. Surfaces of unmodelled objects are
  /// numbered from the number of the scene's surfaces on.
  std::vector<std::uint32_t> surfaces;
  std::vector<std::uint8_t> unmodelled;  ///< per pixel the share of its rays that meet such objects first, of 255
  /// Per pixel what the channels are of 255, neither rounded nor cut off; of Shot::wavelengths_nm alone.
  std::vector<std::array<float, 3>> light{};
};

/// Renders photos of a scene with sun and shadows. Holds an Embree scene.
class SynthRenderer {
 public:
  explicit SynthRenderer(const SynthScene& scene);
  ~SynthRenderer();

  /// A photo through the camera's lens distortion, at 2 x 2 positions a pixel. Uses all TBB threads. `unmodelled`:
  /// objects that are in this photo and not in the scene. \pre shot.rays is a positive multiple of 4
  SynthPhoto photo(const Camera& camera, const Pose& pose, const Shot& shot = {},
                   const SynthScene* unmodelled = nullptr);
  /// True if nothing lies between a point of face `face` and the camera centre: the first face that the ray from the
  /// centre hits is `face` or, in double precision, no nearer than the point.
  bool sees(const Pose& pose, const WorldPoint& p, std::uint32_t face) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes binary little-endian PLY of the coordinates plus `offset`, in float if that is exact, else in double.
void write_synth_mesh(const std::filesystem::path& file, const Mesh& mesh, const WorldPoint& offset);

/// Errors of cameras, as a bundle adjustment leaves them, px: how far the middle of each photo is off by its pose, each another way
/// and turned a little, and the corners of all photos by the lens.
struct CameraErrors {
  double pose_px = 0, lens_px = 0;
  bool any() const { return pose_px != 0 || lens_px != 0; }
};
std::vector<View> with_errors(std::vector<View> views, const CameraErrors& errors, std::uint32_t seed);

/// Writes a COLMAP text model: cameras.txt, images.txt, and points3D.txt with some surface points and the views that see
/// them. Positions and camera centres are moved by `offset`.
/// \param views that took the photos
/// \param written what is said of them
void write_synth_cameras(const std::filesystem::path& dir, const SynthScene& scene, const std::vector<View>& views,
                         const std::vector<View>& written, const SynthRenderer& renderer, const WorldPoint& offset);

/// Writes surfaces.json: material, frame, seed, tint and scale of every surface.
void write_synth_surfaces(const std::filesystem::path& file, const SynthScene& scene);

/// A hash of integers, the only source of randomness in a scene.
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
