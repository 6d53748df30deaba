// What the page colours faces by.
#pragma once

#include <string>
#include <vector>

#include "app/view/asking.h"
#include "app/view/result.h"

namespace gpvc::view {

/// Names of values that face_values() knows of a result: "photo", "tag", and with a scene "gsd", "angle" (of the photo shown, at the
/// face's middle) and "photos" (that see it).
std::vector<std::string> value_names(const Result& result, const Asking* asking);

/// Per face of the model; NaN where there is none. \pre the name is one of value_names(). Counting photos draws all views where they
/// have not been compared: O(views x (faces + pixels)).
std::vector<float> face_values(const std::string& name, const Result& result, const Asking* asking);

}  // namespace gpvc::view
