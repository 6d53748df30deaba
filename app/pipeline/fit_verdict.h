// Says from surfaces on a mesh and off it whether it lies in its place.
#pragma once

#include <array>
#include <cstddef>

#include "app/pipeline/pipeline.h"

namespace gpvc::pipeline {

/// Surfaces that were looked for at some places of a mesh.
struct SurfaceCounts {
  double places = 0, found = 0;
  double on_mesh = 0, off_mesh = 0;  ///< of those found, less what chance adds to either
};

inline constexpr std::size_t kFitGroups = 16;
/// Each from all over the mesh: their differences tell the error of the share.
using FitGroups = std::array<SurfaceCounts, kFitGroups>;

void add(const FitGroups& groups, FitGroups& sums);
MeshFit judge(const FitGroups& groups);

}  // namespace gpvc::pipeline
