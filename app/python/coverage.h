// How well views together see each face.
#pragma once

#include "app/python/python.h"

namespace gpvc::python {

void bind_coverage(py::module_& module);

}  // namespace gpvc::python
