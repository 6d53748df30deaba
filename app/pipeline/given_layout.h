// Texturing on the texture coordinates that a mesh has already (checks::Input::layout).
#pragma once

#include <string>

#include "run.h"

namespace gpvc::pipeline {

/// Notes how the run's layout, if it has one, covers its pages, and warns of faces that it does not serve. Throws InputError
/// where faces lie over each other and Settings::overlap refuses that, where no face has texture coordinates, and for settings that
/// a layout excludes: limits of pages and texels, and pages too large for a WebP in models for the web. O(faces + texels).
void look_at_layout(const Run& run);

/// What follows the model's name in the names of a page's files: "_0", or as a layout says.
std::string page_suffix(const Input& input, std::size_t number);

/// The file of a page of a result: page_name(), or by the name that a layout gives it.
std::string page_file_name(const Input& input, std::size_t number, io::ImageFormat format);

}  // namespace gpvc::pipeline
