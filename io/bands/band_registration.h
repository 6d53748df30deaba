// Where the bands of a photo, taken by lenses beside each other, show the same.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "io/samples.h"
#include "io/scene.h"

namespace gpvc::io {

/// A place of the photo, and how much farther right and down another band shows the same; pixels.
struct BandMatch {
  double x = 0, y = 0, right = 0, down = 0;
};

/// Compares the edges of two bands, as correlation of the magnitudes of their gradients, since what is bright in one may be dark in
/// the other: first of the whole picture, up to an eighth of its size aside, then of squares all over it. Squares that show too little
/// to tell are left out. O(pixels).
std::vector<BandMatch> match_bands(const Samples& photo, std::size_t primary, std::size_t band);

/// The shift, or the affine map if that fits better by a tenth, that fits the matches of several photos, without what is farther off than
/// three times the median. One that is within a tenth of a pixel of a shift by whole pixels, all over the photo, is taken for it, so
/// that samples stay what they are. Without at least kFewestMatches it is no shift, and nothing is known of its error.
BandPlace place_of_matches(std::span<const BandMatch> matches, int width, int height);
inline constexpr std::size_t kFewestMatches = 6;

}  // namespace gpvc::io
