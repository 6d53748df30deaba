// The values every stage shares, and the conventions they are stated in. Depends on samples.h alone.
//
// World    the input's own coordinates, double. UAV scenes are often UTM or ECEF (1e5..1e7 m): subtract a
//          camera centre or a local origin in double before anything becomes float.
// Camera   x right, y down, z forward (OpenCV, COLMAP). x_camera = rotation * (x_world - centre): the centre is
//          stored, not t, so that moving a scene by an exactly representable shift changes no bit downstream.
// Pixel    the view's undistorted frame: same width, height, fx, fy, cx, cy as the photo, distortion removed.
//          Origin at the top-left corner of the image, centre of the first pixel at (0.5, 0.5), y down.
// Photo    the photo as taken, same pixel convention; photo_from_pixel applies the lens distortion and the camera's
//          movement while the photo was read out. Texels are sampled once, from here.
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

#include "samples.h"

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

/// Positions and faces exactly as read: every face of the file, in its order, no digit rounded away. Vertex indices of
/// faces are always valid; degenerate and duplicate faces are kept.
struct Mesh {
  std::vector<WorldPoint> positions;
  std::vector<Triangle> faces;
  /// Per face, the face of the file it was cut from; empty when the file's faces are all triangles, and so the same.
  std::vector<std::uint32_t> source_face{};
  /// Where the file has the positions, if they were taken to other coordinates since; empty: there. Writers write these.
  std::vector<WorldPoint> file_positions{};
  std::string file_srs{};               ///< the reference system of file_positions
  std::vector<std::string> warnings{};  ///< what was left out or assumed, a sentence each

  const std::vector<WorldPoint>& written_positions() const {
    return file_positions.empty() ? positions : file_positions;
  }
};

/// How a direction meets the plane on which the terms of Distortion act, as a factor on (X/Z, Y/Z) by its radius r =
/// tan(theta).
enum class LensModel : std::uint8_t {
  brown,               ///< factor 1, and of the terms k1 k2 p1 p2 k3 alone: OpenCV's five
  perspective,         ///< factor 1
  equidistant,         ///< theta / r: fisheye of OpenCV, COLMAP, OpenSfM, Metashape
  equisolid,           ///< 2 sin(theta / 2) / r
  fov,                 ///< atan(2 r tan(omega / 2)) / (omega r): Devernay and Faugeras 2001; no further term
  inverse_radial,      ///< q / r where q + k1 q^3 = r: VisualSFM; no further term
  division,            ///< q / r where q = r (1 + k1 q^2): Fitzgibbon 2001; no further term
  unified,             ///< 1 / (alpha sqrt(beta r^2 + 1) + 1 - alpha): Khomutenko et al. 2016; no further term
  fisheye_polynomial,  ///< theta (1 + a1 theta + a2 theta^2 + a3 theta^3) / r: Pix4D, ContextCapture; of the terms, skew
  fisheye_624,         ///< theta / r; tangential and prism terms act on what the radial ones make: Project Aria
  spherical,           ///< longitude and latitude in place of (x', y'); no term: see is_spherical()
  spherical_up,        ///< the same of a view whose z is the panorama's up, and whose y down is its front
  spherical_down,      ///< the same of a view whose z is the panorama's down, and whose y down is its back
};

/// The movement of a camera whose photo is read out row by row (rolling shutter). The photo's place (x, y) was read out
/// at time = across (x / width - 1/2) + down (y / height - 1/2), 0 at the pose. What lies at p in the camera's axes then lies
/// at exp(time turn) (p - time step) at that time, with exp(v) the rotation by the length of v about v.
///
/// The step moves a point in the photo by an amount that depends on the point's depth Z. photo_from_pixel knows no depth and
/// takes that of a plane, on which 1 / Z = nearness . (X/Z, Y/Z, 1). This is exact where the scene is flat; elsewhere the
/// step's effect is wrong in proportion to the error of 1 / Z. Readers set nearness to 0, a scene at infinity;
/// checks::set_nearness fits it to the mesh.
struct Motion {
  double across = 0, down = 0;           ///< both 0: the camera stands still
  std::array<double, 3> turn{}, step{};  ///< radians; units of the scene
  std::array<double, 3> nearness{};
  bool operator==(const Motion&) const = default;
  bool moves() const { return across != 0 || down != 0; }
};

/// Where a photo shows what poses, lens and mesh say that it shows at a position of the view's frame: at that position plus a
/// small shift, which is known at the nodes of a grid, `spacing` pixels apart from (0, 0) on, and bilinear between them. Found by
/// comparing photos with each other (atlas::fit_alignment), and used where colours are taken, not to see what hides what.
struct ShiftField {
  int columns = 0, rows = 0;                  ///< 2 at least
  double spacing = 1;                         ///< px
  std::vector<std::array<float, 2>> nodes{};  ///< x and y in pixels, row-major; none: no shift
  bool operator==(const ShiftField&) const = default;
  /// Beyond the grid as at its border. \pre there are nodes
  std::array<double, 2> shift_at(const PixelPoint& p) const;
};

/// Lens distortion. With (x, y) the point that LensModel makes of (X/Z, Y/Z), and r2 = x*x + y*y: radial = (1 + k1 r2 +
/// k2 r2^2 + k3 r2^3 + k4 r2^4 + k5 r2^5 + k6 r2^6) / (1 + d1 r2 + d2 r2^2 + d3 r2^3), more = 1 + p3 r2 + p4 r2^2, x' =
/// x radial + (2 p1 x y + p2 (r2 + 2 x x)) more + s1 r2 + s3 r2^2, y' = y radial + (p1 (r2 + 2 y y) + 2 p2 x y) more +
/// s2 r2 + s4 r2^2, and the photo shows it at (fx (x' + skew y') + cx, fy y' + cy); fisheye_624 takes x radial for x, y
/// radial for y and their r2 in all but the radial term. k1 k2 p1 p2 k3 are named as in OpenCV (whose k4 k5 k6 are d1
/// d2 d3 here); p3 and p4 are Metashape's, s1 to s4 the thin prism.
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  /// Beyond this squared radius of the undistorted plane the model folds back on itself and means nothing:
  /// photo_from_pixel answers nullopt there. Set by limit_distortion; 1e300 where the model never folds.
  double max_r2 = 1e300;
  LensModel model = LensModel::brown;
  double k4 = 0, d1 = 0, d2 = 0, d3 = 0, p3 = 0, p4 = 0, s1 = 0, s2 = 0, skew = 0, omega = 0;
  double k5 = 0, k6 = 0, s3 = 0, s4 = 0, alpha = 0, beta = 0, a1 = 0, a2 = 0, a3 = 0;
  Motion motion{};  ///< none of a panorama
  /// Takes the axes of the view's frame to those of the lens, row-major: a wide fisheye is shown by several views, of which
  /// all but the first look aside. Of these the lens bends the ray lens_from_frame (X, Y, Z) by its angle from the lens's
  /// axis, which may exceed 90 degrees, and (X, Y) / hypot(X, Y) takes the place of (X/Z, Y/Z) / r.
  std::array<double, 9> lens_from_frame{1, 0, 0, 0, 1, 0, 0, 0, 1};
  double max_angle = 0;  ///< radians; farther from the lens's axis the photo shows nothing; 0: not known
  ShiftField aligned{};  ///< photo_from_pixel adds it to positions of the frame before the lens bends them
  bool operator==(const Distortion&) const = default;
  bool looks_aside() const { return lens_from_frame[8] != 1; }
  bool has_lens() const {
    return model != LensModel::brown || k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0 || motion.moves();
  }
  bool is_identity() const { return aligned.nodes.empty() && !has_lens(); }
};

/// True for a view of an equirectangular panorama. A panorama is shown by six views, whose axes are those of a cube, and
/// which see 56 degrees around them. What a view calls its photo is the panorama continued beyond both of its sides
/// (io::continue_around in io/images.h), so that all of the view's surroundings lie next to each other there, at (fx x' +
/// cx, fy y' + cy): x' is the longitude from the view's axis (of spherical_up and spherical_down, from the panorama's
/// middle) to the right, y' the latitude downwards, in radians. fx is the panorama's width over 2 pi, fy its height over
/// pi or equal to fx.
constexpr bool is_spherical(LensModel model) {
  return model == LensModel::spherical || model == LensModel::spherical_up || model == LensModel::spherical_down;
}

/// True if neighbouring positions of the frame may lie far apart in the photo, which must not be interpolated between
/// then: about a pole, where all longitudes meet.
constexpr bool shows_pole(LensModel model) {
  return model == LensModel::spherical_up || model == LensModel::spherical_down;
}

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

/// How a file with a band shows what the photo shows, by the cameras of both as they took them, before any reduction: the ray (x, y, 1) of
/// the photo's frame is file_from_photo (x, y, 1) + shift / Z in the file's, with Z the depth of what it meets.
struct BandCamera {
  Camera photo, file;
  std::array<double, 9> file_from_photo{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major
  WorldPoint shift;                                                  ///< of the photo's centre, in the file's axes
};

struct View {
  std::string name;             ///< as the scene names it, '/'-separated, unique
  std::filesystem::path photo;  ///< where the photo lies on disk
  Camera camera;                ///< at the size the stages work in (already reduced by --downscale)
  Pose pose;
  std::filesystem::path mask{};  ///< image of the photo's size whose black pixels exclude the photo's; or empty
  /// Pixels of the photo are excluded whose alpha is 0, or which a mask that its file holds excludes (of other files with its bands, too).
  bool uses_alpha = false;
  int reduction = 1;         ///< pixels of the photo and the mask to one of the camera, each way
  std::uint32_t number = 0;  ///< the scene's: COLMAP's, which its points refer to; of others the place in their list
  /// Exposure value at ISO 100 that the photo was taken with, by its EXIF data: with one more, a camera gathers half the light.
  std::optional<float> exposure_value{};
  /// Where a photo's bands lie in several files: these, in the order of the bands; `photo`, whose camera the view has, is one of them.
  std::vector<std::filesystem::path> band_files{};
  std::vector<BandCamera> band_cameras{};  ///< one for each of these where the scene has cameras for them, else none
};

/// Where one of View::band_files shows what View::photo shows, the same in all views of a scene: with (x, y) the place in the photo, at
/// (m[0] x + m[1] y + m[2], m[3] x + m[4] y + m[5]), in pixels of files that are not reduced. Views with View::band_cameras go by these.
struct BandPlace {
  std::array<double, 6> file_from_photo{1, 0, 0, 0, 1, 0};
  double nearness = 0;  ///< 1 / Z of BandCamera, one for the whole scene
  /// How far from there, by the median, pictures of the two files that were compared with each other show it; nullopt: they
  /// could not be compared.
  std::optional<double> error_px{};
  bool operator==(const BandPlace&) const = default;
  bool moves() const { return file_from_photo != std::array<double, 6>{1, 0, 0, 0, 1, 0}; }
};

/// Other coordinates that a program writes meshes of the same scene in: x_frame = scale * rotation * (x_scene - origin).
struct SceneFrame {
  std::string name;  ///< "the chunk's own coordinates"
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  WorldPoint origin;
  double scale = 1;
  std::string srs{};  ///< the reference system of these coordinates; empty: none
};

/// A photo that a scene names and that cannot be used.
struct BadPhoto {
  enum class Problem { missing, ambiguous, unreadable, truncated, damaged, turned, other_shape };
  std::string view;  ///< the image's name in the scene's file
  Problem problem{};
  std::string reason{};  ///< what the problem leaves open, without the file: "is 20 x 30 pixels, ..."; may be empty
};

/// A photo as it was when something was read from its pixels.
struct HashedPhoto {
  std::filesystem::path file;
  std::array<std::uint64_t, 2> hash{};  ///< of its bytes, the bits of an io::WorkKey
};

struct Scene {
  std::filesystem::path source;  ///< as given by the user
  std::vector<View> views;       ///< by name, bytewise
  /// Spatial reference system as the format states it (EPSG:2154, a PROJ string, WKT, ENU:LATITUDE,LONGITUDE); empty
  /// when it states none.
  std::string srs{};
  /// To be added to the scene's coordinates to get those of `srs`.
  WorldPoint offset{};
  std::vector<SceneFrame> other_frames{};  ///< most likely first
  std::string reference{};                 ///< a reference system that meshes of the scene may be in; empty: none
  std::string format{};                    ///< which reader read it: "COLMAP"
  std::vector<std::string> warnings{};     ///< what was left out or assumed, a sentence each
  std::vector<BadPhoto> bad_photos{};      ///< of SceneOptions::skip_bad_photos; their views have no photo
  /// The source of the cameras: a file, or a folder of files that belong together.
  std::filesystem::path read_from{};
  std::vector<std::filesystem::path> files{};  ///< the files that belong to it, except photos and masks
  std::vector<HashedPhoto> circle_photos{};    ///< that Distortion::max_angle of wide fisheyes was found in
  /// What the photos hold where that is more than grey or RGB of 8 bits; nullopt: it is not.
  std::optional<BandSet> bands{};
  std::vector<BandPlace> band_places{};  ///< one for each of View::band_files; none where bands lie in one file
};

/// Of the whole scene, in its order.
inline std::vector<ViewId> all_views(const Scene& scene) {
  std::vector<ViewId> views;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) views.push_back(ViewId{v});
  return views;
}

/// +, - and x alone, in this order, so that a shader can repeat it bit for bit.
inline CameraPoint camera_from_world(const Pose& pose, const WorldPoint& p) {
  const double dx = p.x - pose.centre.x, dy = p.y - pose.centre.y, dz = p.z - pose.centre.z;
  const auto& r = pose.rotation;
  return {r[0] * dx + r[1] * dy + r[2] * dz, r[3] * dx + r[4] * dy + r[5] * dz, r[6] * dx + r[7] * dy + r[8] * dz};
}

/// \pre p.z > 0
inline PixelPoint pixel_from_camera(const Camera& camera, const CameraPoint& p) {
  return {camera.fx * (p.x / p.z) + camera.cx, camera.fy * (p.y / p.z) + camera.cy};
}

inline bool is_in_frame(const Camera& camera, const PixelPoint& p) {
  return p.x >= 0 && p.y >= 0 && p.x <= camera.width && p.y <= camera.height;
}

/// nullopt beyond the fold of the distortion model, and where a camera moves too far while it is read out for the search of
/// the row to converge; a point outside [0,W] x [0,H] is returned as it is.
std::optional<PhotoPoint> photo_from_pixel(const Camera& camera, const PixelPoint& p);

/// Where the view's frame has the point; nullopt unless it lies before the camera.
inline std::optional<PixelPoint> pixel_from_world(const View& view, const WorldPoint& p) {
  const CameraPoint c = camera_from_world(view.pose, p);
  if (!(c.z > 0)) return std::nullopt;
  return pixel_from_camera(view.camera, c);
}

/// Where the photo has it; nullopt as of pixel_from_world and photo_from_pixel.
inline std::optional<PhotoPoint> photo_from_world(const View& view, const WorldPoint& p) {
  const std::optional<PixelPoint> q = pixel_from_world(view, p);
  return q ? photo_from_pixel(view.camera, *q) : std::nullopt;
}

/// Inverse of photo_from_pixel by Newton's method, to 1e-9 px; nullopt where it does not converge.
std::optional<PixelPoint> pixel_from_photo(const Camera& camera, const PhotoPoint& p);

/// True when the frame position `p` shows something of the photo: photo_from_pixel lies in [0,W] x [0,H].
bool in_photo(const Camera& camera, const PixelPoint& p);

/// To be called once all terms are set. Fills Distortion::max_r2: the first r2 > 0 at which the radial profile r *
/// radial(r2) stops growing or its divisor vanishes. A perspective lens that needs no more than the five terms of
/// LensModel::brown becomes one.
void limit_distortion(Camera& camera);

/// An upper bound of |d photo / d pixel| where the squared radius of the undistorted plane is at most r2, from the
/// derivative of every term with all signs taken positive; infinity where the bound knows none, as for views that look
/// aside. \pre r2 <= Distortion::max_r2
double largest_stretch(const Camera& camera, double r2);

}  // namespace gpvc
