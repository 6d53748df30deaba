// Models against photos.
#pragma once

#include "app/python/python.h"

namespace gpvc::python {

void bind_evaluate(py::module_& module);

}  // namespace gpvc::python
