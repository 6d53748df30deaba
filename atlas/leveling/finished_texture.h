// Colours of faces that have their texture already, where a part of an atlas is made anew (AtlasInput::finished).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "atlas/atlas.h"
#include "atlas/charts/triangle_spans.h"
#include "atlas/sampling/sampling.h"

namespace gpvc::atlas {

/// True for faces that keep the texture they have.
inline bool is_finished(const AtlasInput& input, std::size_t face) {
  return input.finished != nullptr && input.border[face] != 0;
}

/// The page of a finished face, and where a vertex of the face lies on it, in texels.
const Image& finished_page(const AtlasInput& input, std::size_t face);
TexelPoint finished_place(const AtlasInput& input, std::size_t face, std::uint32_t vertex);

/// The colour at that vertex, in a layer.
Color finished_color(const AtlasInput& input, std::size_t face, std::uint32_t vertex, std::size_t layer = 0);
/// The colour at the point a + t (b - a) of an edge of the face, in a layer.
Color finished_color(const AtlasInput& input, std::size_t face, const std::array<std::uint32_t, 2>& edge, double t,
                     std::size_t layer = 0);

}  // namespace gpvc::atlas
