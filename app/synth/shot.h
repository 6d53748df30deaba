// How a synthetic photo is taken: exposure, lens, the camera's motion while the shutter is open, haze. Like all of synth/
// it uses nothing of libm but sqrt, for the same bits on every machine.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "io/scene.h"

namespace gpvc::synth {

/// A photo's exposure: channels are multiplied by `gain`, and by 1 - `vignetting` in the corners.
struct Exposure {
  std::array<double, 3> gain{1, 1, 1};
  double vignetting = 0;
  /// A channel's factor at the squared distance from the middle of the photo, where 1 is a corner.
  double at(std::size_t channel, double corner_share) const { return gain[channel] * (1 - vignetting * corner_share); }
};

/// A thin lens in the camera's centre; without an aperture, a pinhole.
struct Lens {
  double aperture_m = 0;  ///< diameter of the opening: focal length / f-number
  double focus_m = 1;     ///< depth (z in camera axes) of the plane in focus
  /// Circle of confusion: the diameter in pixels of the disc to which a point at this depth is spread.
  double blur_px(const Camera& camera, double depth_m) const {
    return camera.fx * aperture_m * std::abs(1 / focus_m - 1 / depth_m);
  }
};

/// The camera's motion while the shutter is open: at constant speed, and at the photo's pose halfway.
struct Shake {
  CameraPoint turn_rad{};  ///< rotation over the whole exposure, about an axis of this direction
  CameraPoint travel_m{};  ///< way over the whole exposure
  bool none() const {
    const auto zero = [](const CameraPoint& p) { return p.x == 0 && p.y == 0 && p.z == 0; };
    return zero(turn_rad) && zero(travel_m);
  }
};

/// Unit length.
inline constexpr WorldPoint kTowardsSun{0.4514015204477136, -0.32099663676281853, 0.8325850266035605};

struct Shot {
  WorldPoint towards_sun = kTowardsSun;  ///< unit length
  Exposure exposure;
  Lens lens;
  Shake shake;
  double visibility_m = 0;  ///< distance at which haze leaves a 50th of the contrast; 0: clear air
  /// Rays a pixel of a photo with an aperture or shake, a multiple of 4: one for each of as many places on the lens and
  /// moments of the exposure. Sharp photos take 4.
  int rays = 64;
  double backscatter = 0;  ///< how much brighter all is where one looks straight away from the sun than across its rays
  bool reflections = false;  ///< window panes mirror sky, sun and what is around them
  /// The photo's channels are those of surface_reflectance() at these wavelengths, and SynthPhoto::light is filled.
  std::optional<std::array<double, 3>> wavelengths_nm{};
  bool sharp() const { return lens.aperture_m == 0 && shake.none(); }
};

/// Where and when a ray passes the lens.
struct LensSample {
  double x = 0, y = 0;  ///< on the unit disc
  double time = 0;      ///< from -1/2 to 1/2, the opening and the closing of the shutter
};

/// The n-th of the samples of a pixel: the first of them, however many, are spread evenly over lens and exposure, in an
/// order that differs from pixel to pixel. Additive recurrence of Roberts, "The unreasonable effectiveness of quasirandom
/// sequences" (2018), on the disc by the map of Shirley and Chiu, "A low distortion map between disk and square" (1997).
LensSample lens_sample(std::uint32_t x, std::uint32_t y, std::uint32_t n);

/// In the axes of the camera's pose.
struct CameraRay {
  CameraPoint origin, direction;
};

/// The ray that a lens sample contributes to the position (x, y, 1) of the undistorted image plane. Its direction has the
/// depth 1 in the axes that the camera has at that time.
CameraRay shot_ray(const Shot& shot, double x, double y, const LensSample& sample);

/// The share of its contrast that a colour keeps over a distance in haze: Koschmieder's law, with 2 % at the visibility.
double haze_transmission(double distance_m, double visibility_m);

}  // namespace gpvc::synth
