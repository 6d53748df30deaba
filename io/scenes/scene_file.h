// The interface between the readers of scene formats and read_scene, which does what all formats share: finding photos,
// ordering views, checking sizes, reducing. A format is one file, NAME_scene.cpp, that defines `const SceneFormat&
// NAME_scene()`, which scene_file.cpp lists.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/error.h"
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
  std::vector<std::string> warnings{};
  /// For formats that leave the size of a photo open: their cameras come with width 0, and this turns them into pixels
  /// once the photo is known.
  void (*size_camera)(Camera& camera, int width, int height) = nullptr;
};

struct SceneFormat {
  const char* name;
  const char* expects;  ///< "a COLMAP model (...)", for the error when no format fits
  /// The file or folder to read if `source` is, or contains, a scene of this format.
  std::optional<std::filesystem::path> (*find)(const std::filesystem::path& source);
  /// \pre `found` comes from find. Throws InputError.
  SceneFile (*read)(const std::filesystem::path& found);
  /// Reads from bytes, for formats of a single file; `file` is used in error messages only.
  SceneFile (*parse)(const std::filesystem::path& file, std::string_view bytes) = nullptr;
};

// One function a format, each in the file of its name; a new one is also listed in scene_file.cpp.
const SceneFormat& blocks_exchange_scene();
const SceneFormat& cam_scene();
const SceneFormat& colmap_scene();
const SceneFormat& metashape_scene();
const SceneFormat& openmvs_scene();
const SceneFormat& opensfm_scene();

/// All of them, by name of their source file.
std::span<const SceneFormat* const> scene_formats();

// --- parts that readers share

/// The first `count` bytes of a file; fewer if it is shorter, none if it cannot be read.
std::string first_bytes(const std::filesystem::path& file, std::size_t count);

/// The one file of `folder` with this extension (any case) that `fits`; nullopt when there is none. Throws InputError
/// that names them when there are several.
std::optional<std::filesystem::path> only_file(const std::filesystem::path& folder, std::string_view extension,
                                               bool (*fits)(const std::filesystem::path&));

/// The folder of a file, "." for a bare name.
std::filesystem::path folder_of(const std::filesystem::path& file);

/// Turns '\' into '/' and drops "file:///": for paths written on Windows.
std::string slashed(std::string_view path);

/// Checks that sizes lie within 1 .. 2^24 (safe in every product of two sides), terms are finite and focal lengths
/// positive; then calls limit_distortion. Throws InputError at `place`. A camera of width 0 (see
/// SceneFile::size_camera) passes.
void finish_camera(const std::filesystem::path& file, const std::string& place, Camera& camera);

using Matrix3 = std::array<double, 9>;  ///< row-major

Matrix3 product(const Matrix3& a, const Matrix3& b);
Matrix3 transposed(const Matrix3& m);
WorldPoint product(const Matrix3& m, const WorldPoint& p);

/// The rotation of a quaternion w x y z of any length; nullopt when it has no direction.
std::optional<Matrix3> rotation_from_quaternion(const std::array<double, 4>& q);

/// The rotation closest to `m`, which files print with few digits; nullopt when an entry of m m^T differs by more than
/// 0.01 from the identity: three printed decimals still pass.
std::optional<Matrix3> rotation_near(const Matrix3& m);

/// Throws InputError unless rotation and centre are numbers.
Pose finish_pose(const std::filesystem::path& file, const std::string& place, const Matrix3& rotation,
                 const WorldPoint& centre);

}  // namespace gpvc::io
