// How different two colours look.
#pragma once

#include <array>

namespace gpvc {

/// The light of a level of sRGB (IEC 61966-2-1) in [0, 255], which need not be whole; 1 is that of 255.
double light_of_level(double level);

/// CIE L*a*b* for the white point D65. L is in [0, 100].
struct LabColor {
  double l = 0, a = 0, b = 0;
};

/// Of sRGB (IEC 61966-2-1) with levels in [0, 255], which need not be whole.
LabColor lab_from_srgb(const std::array<float, 3>& rgb);

/// CIEDE2000 with all weights 1 (Sharma, Wu, Dalal 2005): 0 for equal colours, about 1 where a difference is just seen.
double color_difference(const LabColor& first, const LabColor& second);

}  // namespace gpvc
