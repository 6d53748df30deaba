// The interface between the readers of scene formats and read_scene, which does what all formats share: finding photos,
// ordering views, checking sizes, reducing. A format is one file, NAME_scene.cpp, that defines a SceneFormat, which
// scene_file.cpp lists.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/error.h"
#include "io/files/paths.h"
#include "io/scene.h"

namespace gpvc::io {

struct SceneFile {
  /// Names, cameras at full size and poses, in any order. Names may be whole paths: read_scene makes them relative and
  /// unique. View::photo and View::mask are the paths that the file states, with '/', or empty.
  std::vector<View> views{};
  /// The file that lists the images; error messages about them name it.
  std::filesystem::path listing{};
  /// All files that belong to the scene, where that is more than `listing`.
  std::vector<std::filesystem::path> files{};
  /// Where photos usually lie for this format, best guess first.
  std::vector<std::filesystem::path> image_folders{};
  std::string srs{};
  WorldPoint offset{};
  std::vector<SceneFrame> other_frames{};
  std::string reference{};
  std::vector<std::string> warnings{};
  std::vector<BadPhoto> bad_photos{};  ///< of views that need them
  /// Where a layer takes the place of a photo: the photo, beside which masks lie, by the layer.
  std::map<std::filesystem::path, std::filesystem::path> photos_of_layers{};
  /// For each of View::band_files the name of its band; empty where the file's name does not say it.
  std::vector<std::string> band_names{};
  std::optional<BandSet> bands{};
  std::vector<BandPlace> band_places{};
  /// For formats that leave the size of a photo open: their cameras come with width 0, and this turns them into pixels
  /// once the photo is known.
  void (*size_camera)(Camera& camera, int width, int height) = nullptr;

  /// Adds the warning "COUNT WHAT" unless the count is 0.
  void warn(std::size_t count, const std::string& what) {
    if (count > 0) warnings.push_back(std::to_string(count) + " " + what);
  }
};

struct SceneFormat {
  const char* name;
  const char* expects;  ///< "a COLMAP model (...)", for the error when no format fits
  /// The file or folder to read if `source` is, or contains, a scene of this format.
  std::optional<std::filesystem::path> (*find)(const std::filesystem::path& source);
  /// Reads from the bytes of one file; `file` is used in error messages only. Throws InputError. Null for formats of
  /// several files.
  SceneFile (*parse)(const std::filesystem::path& file, std::string_view bytes) = nullptr;
  /// Where photos lie relative to the scene's file, best guess first and before its own folder.
  std::array<const char*, 3> image_folders{};
  /// Takes the place of parse and image_folders where more than one file is read. \pre `found` comes from find. Throws
  /// InputError.
  SceneFile (*read)(const std::filesystem::path& found) = nullptr;
};

/// All of them, by name of their source file.
std::span<const SceneFormat* const> scene_formats();

// --- parts that readers share

/// `source` if it `fits`, or else the one file with this extension (any case) in the folder `source` that does; nullopt
/// when there is none. Throws InputError that names them when there are several.
std::optional<std::filesystem::path> find_file(const std::filesystem::path& source, std::string_view extension,
                                               bool (*fits)(const std::filesystem::path&));

/// `source` if it is a folder with a file that `fits`, or the folder of `source` if that is such a file; nullopt otherwise.
std::optional<std::filesystem::path> find_folder(const std::filesystem::path& source,
                                                 bool (*fits)(const std::filesystem::path&));

/// A file that states the camera of the photo beside it.
struct Sidecar {
  std::filesystem::path file;
  /// The photo's file name. Where none or several lie beside it, the sidecar's own name without extension.
  std::string photo;
};

/// The files of a folder with this extension (any case), by name: NAME.EXTENSION of the photo NAME or NAME.ANY.
std::vector<Sidecar> sidecars_in(const std::filesystem::path& folder, std::string_view extension);

/// Views with a lens that no LensModel describes (a panorama's) are left out of a scene that has others; a scene
/// without others is refused.
class OmittedLenses {
 public:
  /// One view of the lens; `refusal` says what is wrong with it, and where.
  void add(const std::string& lens, const InputError& refusal);
  /// To be called after the last view was added: warns of the omitted ones. Throws the first refusal if the scene has no
  /// other views.
  void report(SceneFile& scene, const char* views = "images") const;

 private:
  std::map<std::string, std::size_t> counts_;
  std::optional<InputError> first_;
};

/// `value` as the side of an image; nullopt unless it is a whole number of 1 to 2^24, which is safe in every product of
/// two sides.
std::optional<int> image_side(double value);

/// `name`, a photo's as the scene states it, with '/'. Throws InputError at `place` where it names no file: the last part of
/// the path is missing, "." or "..", or a drive.
std::string stated_photo_name(const std::filesystem::path& file, const std::string& place, std::string name);

/// Checks that sizes lie within 1 .. 2^24, terms are finite and focal lengths positive; then calls limit_distortion.
/// Throws InputError at `place`. A camera of width 0 (see SceneFile::size_camera) passes.
void finish_camera(const std::filesystem::path& file, const std::string& place, Camera& camera);

/// Pix4D's fisheye, which is ContextCapture's as well (Pix4D, "Camera internals for fisheye lens"): a direction at the angle
/// theta from the axis and beta about it is shown at affine * rho (cos beta, sin beta), with rho the polynomial in 2 theta /
/// pi, from its constant term on. Sets focal lengths and lens. What is left is a turn of the camera about its axis, to be
/// multiplied to the left of the rotation to the camera. Throws InputError at `place` unless the polynomial begins with 0
/// and ends with the fourth power, and the affine can be undone.
std::array<double, 9> set_fisheye(const std::filesystem::path& file, const std::string& place,
                                  const std::array<double, 4>& affine, std::span<const double> polynomial,
                                  Camera& camera);

/// A definition of a reference system in one line; empty for a local one (LOCAL_CS, ENGCRS), which states no place.
std::string reference_system(std::string_view definition);

using Matrix3 = std::array<double, 9>;  ///< row-major

Matrix3 product(const Matrix3& a, const Matrix3& b);
Matrix3 transposed(const Matrix3& m);
WorldPoint product(const Matrix3& m, const WorldPoint& p);

/// The rotation of a quaternion w x y z of any length; nullopt when it has no direction.
std::optional<Matrix3> rotation_from_quaternion(const std::array<double, 4>& q);
/// Its inverse, of length 1.
std::array<double, 4> quaternion(const Matrix3& rotation);

/// The rotation by the vector's length about its direction; nullopt unless it is finite.
std::optional<Matrix3> rotation_from_angle_axis(const WorldPoint& v);
/// Its inverse, of a length up to pi.
std::array<double, 3> angle_axis_from_rotation(const Matrix3& rotation);
/// Rx(omega) Ry(phi) Rz(kappa) of photogrammetry, angles in degrees.
Matrix3 rotation_from_angles(const std::array<double, 3>& omega_phi_kappa);

/// The rotation closest to `m`, which files print with few digits; nullopt when an entry of m m^T differs by more than
/// 0.01 from the identity: three printed decimals still pass.
std::optional<Matrix3> rotation_near(const Matrix3& m);

/// Throws InputError unless rotation and centre are numbers.
Pose finish_pose(const std::filesystem::path& file, const std::string& place, const Matrix3& rotation,
                 const WorldPoint& centre);

/// The same from x_camera = rotation * x_world + t.
Pose finish_pose_from_translation(const std::filesystem::path& file, const std::string& place, const Matrix3& rotation,
                                  const WorldPoint& t);

}  // namespace gpvc::io
