// Says from surfaces on a mesh and off it whether it lies in its place.
#pragma once

#include <array>
#include <cstddef>

namespace gpvc::checks {

/// Whether the mesh lies on the surfaces that photos show. Two photos agree best about a place where it really is, rather than
/// at another distance along the line of sight; and tie points lie on surfaces.
struct MeshFit {
  enum class Verdict { unknown, fits, doubtful, elsewhere };
  std::size_t places = 0;  ///< that were compared: with texture in photos, or tie points
  std::size_t found = 0;   ///< of them, those with a surface, on the mesh or off it: photos agree better than by chance
  double share = 0;        ///< of those found, on the mesh; what chance adds to either is subtracted; 0..1
  double error = 0;        ///< standard error of the share
  Verdict verdict = Verdict::unknown;
};

/// Surfaces that were looked for at some places of a mesh.
struct SurfaceCounts {
  double places = 0, found = 0;
  double on_mesh = 0, off_mesh = 0;  ///< of those found, less what chance adds to either
};

inline constexpr std::size_t kFitGroups = 16;
/// Each from all over the mesh: their differences tell the error of the share.
using FitGroups = std::array<SurfaceCounts, kFitGroups>;

void add(const FitGroups& groups, FitGroups& sums);
/// True if they may be counts of surfaces that chance adds nothing to: whole, as many as there can be points, and those found are
/// on the mesh or off it.
bool are_counts(const FitGroups& groups);
MeshFit judge(const FitGroups& groups);

}  // namespace gpvc::checks
