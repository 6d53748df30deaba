// Which faces views see.
#pragma once

#include "app/python/python.h"

namespace gpvc::python {

void bind_visibility(py::module_& module);

}  // namespace gpvc::python
