// Where a band's file shows what its photo shows, by cameras that the scene has for both.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "io/bands/band_registration.h"
#include "io/photo_pixel.h"
#include "io/scene.h"

namespace gpvc::io {

/// place_in_file() for a whole photo: exact at the nodes of a grid and bilinear between them, which changes by less than .02 px with lenses of
/// cameras for mapping.
class BandGrid {
 public:
  BandGrid(const BandCamera& band, double nearness);
  /// Of a position of the photo. nullopt as of place_in_file().
  std::optional<PhotoPoint> at(double x, double y) const;

 private:
  static constexpr int kStep = 32;  ///< pixels
  int columns_ = 0;
  std::vector<std::optional<PhotoPoint>> nodes_;  ///< row-major from (0, 0) on
};

/// A match that was found with the band laid over the photo by its camera, for a scene at infinity.
struct CameraMatch {
  BandMatch match;
  const BandCamera* band;
};

/// Of what photos show, and how far pictures lie from where it puts them, in the median, with what was matched.
struct NearnessFit {
  double nearness = 0;
  std::optional<double> error_px{};  ///< nullopt: fewer than kFewestMatches matches
};

/// The nearness with which the matches fit best, the same for all; 0, a scene at infinity, unless the error falls by a tenth with it.
NearnessFit fit_nearness(std::span<const CameraMatch> matches);

}  // namespace gpvc::io
