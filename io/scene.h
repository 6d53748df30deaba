// The values every stage shares, and the conventions they are stated in. Depends on nothing.
//
// World    the input's own coordinates, double. UAV scenes are often UTM or ECEF (1e5..1e7 m): subtract a
//          camera centre or a local origin in double before anything becomes float.
// Camera   x right, y down, z forward (OpenCV, COLMAP). x_camera = rotation * (x_world - centre): the centre
// is
//          stored, not t, so that moving a scene by an exactly representable shift changes no bit downstream.
// Pixel    the view's undistorted frame: same width, height, fx, fy, cx, cy as the photo, distortion removed.
//          Origin at the top-left corner of the image, centre of the first pixel at (0.5, 0.5), y down.
// Photo    the photo as taken, same pixel convention; photo_from_pixel applies the lens distortion. Texels
// are
//          sampled once, from here.
// Faces    counter-clockwise seen from outside; indexed as in the input file, in every output.
// Views    ordered by image name, bytewise, whatever the format.
// Transforms are named target_from_source, so adjacent names match: pixel_from_camera(camera_from_world(p)).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace gpvc {

struct WorldPoint {
  double x = 0, y = 0, z = 0;
  bool operator==(const WorldPoint&) const = default;
};

struct CameraPoint {
  double x = 0, y = 0, z = 0;
};

/// A point of the undistorted frame, in pixels.
struct PixelPoint {
  double x = 0, y = 0;
};

/// A point of the original photo, in pixels.
struct PhotoPoint {
  double x = 0, y = 0;
};

enum class FaceId : std::uint32_t {};
enum class ViewId : std::uint32_t {};

inline constexpr FaceId kNoFace{0xFFFFFFFFu};
/// As int32 this is -1, the "no view" of labels.npy.
inline constexpr ViewId kNoView{0xFFFFFFFFu};

constexpr std::size_t index(FaceId face) { return static_cast<std::size_t>(face); }
constexpr std::size_t index(ViewId view) { return static_cast<std::size_t>(view); }

using Triangle = std::array<std::uint32_t, 3>;

/// Positions and faces exactly as read: every face of the file, in its order, no digit rounded away.
/// Vertex indices of faces are always valid; degenerate and duplicate faces are kept.
struct Mesh {
  std::vector<WorldPoint> positions;
  std::vector<Triangle> faces;
};

/// Brown-Conrady lens distortion on the normalized plane (x = X/Z, y = Y/Z), coefficients named as in OpenCV:
/// r2 = x*x + y*y, radial = 1 + k1 r2 + k2 r2^2 + k3 r2^3,
/// x' = x radial + 2 p1 x y + p2 (r2 + 2 x x), y' = y radial + p1 (r2 + 2 y y) + 2 p2 x y.
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  /// Beyond this squared radius of the undistorted plane the model folds back on itself and means nothing:
  /// photo_from_pixel answers nullopt there. Set by limit_distortion; infinity where the model never folds.
  double max_r2 = 1e300;
  bool operator==(const Distortion&) const = default;
  bool is_identity() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
};

/// Intrinsics of a photo and, without the distortion, of its undistorted frame. Pixels; fx, fy > 0.
struct Camera {
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Distortion distortion;
  bool operator==(const Camera&) const = default;
};

/// x_camera = rotation * (x_world - centre); rotation is row-major, orthonormal, det +1.
struct Pose {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  WorldPoint centre;
};

struct View {
  std::string name;             ///< as the scene names it, '/'-separated, unique
  std::filesystem::path photo;  ///< where the photo lies on disk
  Camera camera;                ///< at the size the stages work in (already reduced by --downscale)
  Pose pose;
};

struct Scene {
  std::filesystem::path source;  ///< as given by the user
  std::vector<View> views;       ///< by name, bytewise
};

/// +, - and x alone, in this order, so that a shader can repeat it bit for bit.
inline CameraPoint camera_from_world(const Pose& pose, const WorldPoint& p) {
  const double dx = p.x - pose.centre.x, dy = p.y - pose.centre.y, dz = p.z - pose.centre.z;
  const auto& r = pose.rotation;
  return {r[0] * dx + r[1] * dy + r[2] * dz, r[3] * dx + r[4] * dy + r[5] * dz,
          r[6] * dx + r[7] * dy + r[8] * dz};
}

/// \pre p.z > 0
inline PixelPoint pixel_from_camera(const Camera& camera, const CameraPoint& p) {
  return {camera.fx * (p.x / p.z) + camera.cx, camera.fy * (p.y / p.z) + camera.cy};
}

/// nullopt beyond the fold of the distortion model; a point outside [0,W] x [0,H] is returned as it is.
std::optional<PhotoPoint> photo_from_pixel(const Camera& camera, const PixelPoint& p);

/// Inverse of photo_from_pixel by Newton's method, to 1e-9 px; nullopt where it does not converge.
std::optional<PixelPoint> pixel_from_photo(const Camera& camera, const PhotoPoint& p);

/// True when the frame position `p` shows something of the photo: photo_from_pixel lies in [0,W] x [0,H].
bool in_photo(const Camera& camera, const PixelPoint& p);

/// Fills Distortion::max_r2: the first r2 > 0 at which the radial profile r * radial(r2) stops growing.
void limit_distortion(Camera& camera);

}  // namespace gpvc
