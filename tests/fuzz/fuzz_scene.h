// Scene formats of a single file, from bytes.
#pragma once

#include <cmath>
#include <filesystem>
#include <string_view>

#include "fuzz.h"
#include "io/scenes/fisheye_views.h"
#include "io/scenes/panorama_views.h"
#include "io/scenes/scene_file.h"

namespace gpvc::fuzz {

inline void expect_sound(const io::SceneFile& scene) {
  for (const View& view : scene.views) {
    const bool sound = view.camera.fx > 0 && view.camera.fy > 0 && std::isfinite(view.pose.centre.x) &&
                       std::isfinite(view.pose.rotation[0]) && std::filesystem::path(view.name).has_filename();
    if (!sound) std::abort();
    if (view.camera.width == 0) continue;
    for (const View& shown : io::views_of(view))
      for (const View& part : io::fisheye_views(shown))
        if (part.name.empty() || !std::isfinite(part.pose.rotation[0])) std::abort();
  }
}

/// The format's parser accepts with sound cameras and poses, or refuses.
inline int parse_scene(std::string_view format, const char* name, const std::uint8_t* data, std::size_t size) {
  for (const io::SceneFormat* candidate : io::scene_formats()) {
    if (candidate->name != format) continue;
    return reads_or_refuses([&] { expect_sound(candidate->parse(folder() / name, fuzz::view(data, size))); });
  }
  std::abort();
}

}  // namespace gpvc::fuzz
