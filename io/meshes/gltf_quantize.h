// Positions in 16 bits, and an order of triangles that compresses well.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "io/meshes/gltf_geometry.h"
#include "io/textured_model.h"

namespace gpvc::io {

/// The grid that all positions of a model are rounded to: a vertex lies at origin + step * n, with n from 0 to 65535. The step is
/// a power of two and the origin a multiple of it, so that models with one step beside each other have the same grid and
/// their common vertices do not part, and 32-bit floats hold each place exactly.
struct PositionGrid {
  WorldPoint origin;
  double step = 1;
  std::array<std::uint16_t, 3> place(const WorldPoint& p) const;
};

/// The finest grid for the positions, less the offset, of which the geometry's vertices consist. nullopt where it is too coarse: a
/// step is to be at most an eighth of nearly all edges (nine in ten). O(vertices + faces).
std::optional<PositionGrid> position_grid(const TexturedModel& model, const GltfGeometry& geometry,
                                          const WorldPoint& offset);

/// Orders the triangles of each primitive so that those that follow each other share vertices, and numbers vertices in the order
/// of their first use. Corners of a triangle stay in their order. O(faces log faces).
void order_triangles(GltfGeometry& geometry);

}  // namespace gpvc::io
