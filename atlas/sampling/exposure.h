// What the exposure that leveling finds for a view makes of a photo's colours.
#pragma once

#include <algorithm>
#include <cmath>

#include "atlas/atlas.h"
#include "atlas/sampling/color.h"

namespace gpvc::atlas {

/// The most that a channel's gain, and what undoes the fall-off of the lens, multiply a colour by; the least are 1 / these.
/// Light falls with the fourth power of the cosine of the angle to the lens's axis: to a quarter at 45 degrees, in the
/// corner of a photo with a field of view of 90. A fit that asks for more has mostly continued its polynomial beyond the
/// radii of its seams; of a wider lens the rest of the fall-off stays.
inline constexpr double kMostGain = 2.5, kMostFallOff = 4;
inline const double kMostFallOffLog = std::log(kMostFallOff);

/// Limits the logarithm of what undoes a fall-off, wherever a frame reaches. NaN, of coefficients whose terms overflow,
/// becomes the upper limit.
inline double limited_falloff(double log) { return std::max(-kMostFallOffLog, std::min(kMostFallOffLog, log)); }

/// What the exposure multiplies a colour at a position of the view's frame by: at most kMostGain kMostFallOff.
/// \pre is_sound(exposure)
Color gain_at(const ViewExposure& exposure, const PixelPoint& frame);

/// The corrected colour of a texel. `exposed` is `gain` times the photo's colour, `added` the offset and the strip. The sum has two
/// limits:
/// - Tint. Offsets close the step between two photos; where these show different things, they would make a colour that no photo has,
///   such as blue leaves. So the factor by which a channel changes is kept within 1.25 times the mean factor of the three, and that
///   within kMostGain.
/// - Highlights, see with_highlights().
Color corrected(const Color& exposed, const Color& added, const Color& gain);
/// Grey levels from which on a channel is a highlight.
inline constexpr float kHighlight = 200;
/// Channel values above kHighlight are compressed if the gain is above 1, so that only what is 255 in the photo becomes 255.
float with_highlights(float exposed, float gain);

/// gain_at in the neighbourhood of a position, without an exponential for each place. Where the fall-off changes the
/// gain by less than a tenth, the error is below a five-thousandth of it (the third power of a tenth, over 3!).
class LocalGain {
 public:
  LocalGain(const ViewExposure& exposure, const PixelPoint& middle);
  Color at(const PixelPoint& frame) const {
    const double change = falloff(frame) - middle_;
    return static_cast<float>(1 + change * (1 + change / 2)) * gain_;
  }

 private:
  double falloff(const PixelPoint& frame) const {
    const double dx = frame.x - exposure_.centre_x, dy = frame.y - exposure_.centre_y;
    const double r2 = (dx * dx + dy * dy) * exposure_.inverse_radius2;
    return limited_falloff(r2 * (exposure_.k1 + exposure_.k2 * r2));
  }
  ViewExposure exposure_;
  double middle_;  ///< logarithm of the gain there, without the view's own
  Color gain_;     ///< in the middle
};

}  // namespace gpvc::atlas
