// Cameras and photos as the module holds them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "app/python/python.h"
#include "io/photos.h"
#include "io/scene.h"

namespace gpvc::python {

/// A scene with its photos: in the files that it names or, where there is such an object, as that gives them.
struct PhotoScene {
  std::shared_ptr<const Scene> scene;
  /// Has picture(i) -> (rgb, excluded) of view i: (H, W, 3) uint8, C-contiguous, of the camera's size, and (H, W) bool, true for
  /// pixels that must not be used, or None; and excluded(i), the latter alone. Of a scene with bands rgb is (H, W, bands), in their type.
  /// None: photos are in files.
  std::shared_ptr<const py::object> pictures;

  /// \param views the scene's or some of them, borrowed; with `numbers`, the scene's numbers of its views
  std::unique_ptr<io::PhotoSource> photos(const Scene& views, std::vector<std::uint32_t> numbers = {}) const;
};

/// Of a (H, W) array of bool. \pre the interpreter's lock is held
std::optional<io::PhotoExclusion> exclusion_from(const py::object& excluded);

void bind_scene(py::module_& module);

}  // namespace gpvc::python
