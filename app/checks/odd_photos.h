// Explains single photos that do not agree with the others.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/checks/input.h"
#include "app/checks/mesh_fit.h"

namespace gpvc::checks {

/// Tries what happens to single photos: that they are turned or mirrored, or were taken where another view stands. Returns a
/// clause such as "a.jpg shows what b.jpg's camera sees" for each of the `odd` views, at most four, that one of these makes
/// agree with the views around it. \param odd of the input's views, ascending. Tenths of a second.
std::vector<std::string> explain_photos(const Input& input, std::span<const SmallPhoto> photos,
                                        std::span<const ViewId> odd, results::Observer& observer);

}  // namespace gpvc::checks
