// Texture coordinates that a mesh has already.
#pragma once

#include <string>

#include "app/python/python.h"
#include "io/uv_layout.h"

namespace gpvc::python {

/// As arrays or the file of a model state them.
struct MeshUv {
  io::StatedUv stated;
  std::string name;  ///< in messages
};

void bind_uv(py::module_& module);

}  // namespace gpvc::python
