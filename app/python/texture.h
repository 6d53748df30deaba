// Texturing, and its result.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/pipeline/pipeline.h"
#include "app/python/python.h"
#include "app/python/scene.h"
#include "io/uv_layout.h"

namespace gpvc::python {

/// What texture() gives, with all that writing it takes.
struct TextureResult {
  Scene scene;
  Mesh mesh;
  std::vector<ViewId> views;
  pipeline::Settings settings;
  pipeline::TexturedMesh textured{};
  std::string report{};                  ///< JSON
  std::optional<io::UvLayout> layout{};  ///< where the faces lie on pages, if the mesh says so

  pipeline::Input input() const {
    if (layout) return {scene, mesh, views, std::string(kMeshName) + ", uv", &*layout};
    return {scene, mesh, views, kMeshName};
  }
  static constexpr const char* kMeshName = "vertices, faces";  ///< in messages about the mesh
};

/// From arrays (V, 3) and (F, 3), whose indices are valid.
Mesh mesh_from(const py::array_t<double, py::array::c_style>& vertices,
               const py::array_t<std::uint32_t, py::array::c_style>& faces);

void bind_texture(py::module_& module);

}  // namespace gpvc::python
