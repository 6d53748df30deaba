// Settings from keyword arguments, by the lists that the command line's options come from (app/pipeline/options.h).
#pragma once

#include "app/pipeline/settings.h"
#include "app/python/python.h"

namespace gpvc::python {

/// Settings with what a dictionary of keyword arguments names. Raises ValueError for a value that an option cannot have, and
/// TypeError for a name or a type that none has.
pipeline::Settings settings_from(const py::dict& options);
visibility::VisibilityOptions visibility_options_from(const py::dict& options);

/// Each option that texture() takes: a dictionary of name, type ("bool", "int", "float", "str"), default, choices, least, most, help
/// and group.
py::list texture_options();
/// The same of visibility() and face_ids().
py::list visibility_options();

}  // namespace gpvc::python
