// What OpenSfM's reconstruction.json shares with what OpenDroneMap makes of it.
#pragma once

#include <optional>
#include <string>

#include "io/scenes/json_file.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

struct OpensfmCamera {
  Camera camera;
  std::string lens;                   ///< its projection type
  std::optional<InputError> refusal;  ///< for OmittedLenses, where the lens is not supported
};

/// A member of the object `cameras`. Throws InputError.
OpensfmCamera read_opensfm_camera(const JsonFile& json, const std::string& id, const Json& camera);

/// OpenDroneMap's coords.txt in the project's folder odm_georeferencing, or a file that stands in for it: the system, then
/// easting and northing of the offset. proj.txt states the system better. A warning where there is none. Throws InputError.
void read_georeferencing(const std::filesystem::path& project, SceneFile& scene);
/// The same from the bytes of both files; `proj_text` is empty where there is none.
void parse_georeferencing(const std::filesystem::path& coords, std::string_view coords_text, std::string_view proj_text,
                          SceneFile& scene);

/// From the bytes of shots.geojson and cameras.json, with the offset of coords.txt still in all positions. Throws
/// InputError.
SceneFile parse_odm_shots(const std::filesystem::path& shots, std::string_view shots_text,
                          const std::filesystem::path& cameras, std::string_view cameras_text);

}  // namespace gpvc::io
