// Black borders of photos: what undistortion leaves where it knows nothing, and the backgrounds of objects that were cut out.
#pragma once

#include <cstddef>

#include "../../io/error.h"
#include "../../io/image.h"
#include "../../io/scene.h"

namespace gpvc::checks {

/// The share of a photo's pixels that are black, or nearly so, and are reached from its edge through such pixels alone,
/// along the row or the column. O(those pixels + width + height).
double black_border_share(const Image& photo);

/// Looks at one photo after another.
class BlackBorders {
 public:
  /// Photos of panoramas and fisheyes, around whose circle it is black, are not looked at.
  void add(const Camera& camera, const Image& photo);
  /// A warning with the share, if photos have such borders as a rule.
  Remark remark() const;

 private:
  std::size_t photos_ = 0, bordered_ = 0;
  double share_ = 0;  ///< of the bordered ones, summed
};

}  // namespace gpvc::checks
