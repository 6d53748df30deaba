// The coordinates of an orthophoto.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/ortho/ortho_settings.h"
#include "app/ortho/surface.h"

namespace gpvc::ortho {

struct Frame {
  std::string wkt{};   ///< the reference system; empty: none
  std::string name{};  ///< a sentence on what x, y and heights are
};

/// Takes a surface's positions to those of its orthophoto: x to the right, y up the picture, z the height. Throws InputError where a
/// system is asked for that the surface cannot be taken to, Error where PROJ does not know one or lacks a grid for its heights.
Frame place_surface(Surface& surface, const OrthoSettings& settings);

}  // namespace gpvc::ortho
