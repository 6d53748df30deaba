// Errors of the libraries as Python exceptions, in the words of Python arguments.
#pragma once

#include <span>
#include <string>

#include "io/error.h"

namespace gpvc::python {

/// The sentence with what a caller of the module can do about it: "SENTENCE; keep_odd_photos=True textures with them all the
/// same".
std::string with_arguments(const std::string& sentence, std::span<const Cure> cures);

/// From now on InputError, OutputError and other errors of the libraries are those of gpvc._errors.
void register_errors();

}  // namespace gpvc::python
