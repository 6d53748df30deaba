// What photos show around a place on the mesh, and how far two of them are apart there.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/alignment/surface_grid.h"
#include "io/image.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// Brightness of a coarse photo, in grey levels; row-major.
struct CoarseLuma {
  int width = 0, height = 0;
  std::vector<std::uint8_t> levels;
};
/// \param means io::coarse_image() of the photo. O(pixels).
CoarseLuma coarse_luma(const Image& means);

/// Brightness, in grey levels, at the points of a grid on the mesh (surface_grid.h). Patches that views give of the same grid are
/// alike where poses, lens and mesh are right. Row-major.
struct Patch {
  std::array<std::uint8_t, kPatchEdge * kPatchEdge> luma{};
};

/// What a view's photo shows; nullopt where it does not reach, or shows the surface more than twice as fine or as coarse as the
/// reference does.
std::optional<Patch> take_patch(const Scene& scene, const SurfacePlace& place, const GridDepths& depths, ViewId view,
                                const CoarseLuma& luma);

/// How far a patch of one photo is from that of the reference: at the place plus (x, y), in pixels of the reference's frame, it
/// shows what the reference has at the place.
struct PatchShift {
  double x = 0, y = 0;
  /// xx, xy and yy of the inverse of the covariance of (x, y), 1 / px^2. Along a straight edge nothing is known.
  std::array<double, 3> information{};
  double correlation = 0;  ///< of both, once shifted
};

/// The length of the shift (x, y), px, each direction weighted by how well the texture fixes it: 1 if to a quarter of a pixel or
/// better, 0 along a straight edge.
double misfit(double x, double y, const std::array<double, 3>& information);

/// True if brightness changes by more than the noise of photos (kPhotoNoise) from one sample to the next along some direction, in
/// the root mean square: the shift along it is found to a tenth of a pixel then.
bool has_texture(const Patch& reference);

/// The shift at which the middle of the reference, kPatchWindow samples wide, correlates best with the other: found among whole
/// samples up to kPatchReach, then between them by Gauss-Newton steps on brightness up to gain and offset (Lucas and Kanade
/// 1981; Baker and Matthews 2004, inverse compositional). nullopt where the best is none (a correlation below 0.7), lies at the
/// end of the reach, or is one of several.
std::optional<PatchShift> shift_between(const Patch& reference, const Patch& other);

inline constexpr std::size_t kPatchWindow = 16;
inline constexpr std::size_t kPatchReach = (kPatchEdge - kPatchWindow) / 2;

}  // namespace gpvc::atlas
