// MicMac's orientations from bytes.
#pragma once

#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// One Orientation-PHOTO.xml, whose file name names the photo, and the camera's file that it refers to. Throws InputError.
/// \pre the orientation's file name is long enough
SceneFile parse_micmac(const std::filesystem::path& orientation, std::string_view orientation_text,
                       const std::filesystem::path& camera, std::string_view camera_text);

}  // namespace gpvc::io
