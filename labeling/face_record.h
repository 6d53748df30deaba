// What one view tells of one face, as files between the steps of a run hold it.
#pragma once

#include <array>
#include <cstdint>

namespace gpvc::labeling {

/// A share in [0, 1] in steps of 1/65535; 0 and 1 are exact.
using Share16 = std::uint16_t;
inline constexpr Share16 kWholeShare = 65535;

/// One face in one view: 24 bytes, since a scene has tens of millions of them.
struct FaceRecord {
  std::uint32_t face = 0;
  float quality = 0;  ///< of the chosen data term, >= 0, more is better; px^2, grey levels px, or a share
  std::array<std::uint16_t, 3> color{};  ///< mean R, G, B of the pixels that show the face, times 256
  Share16 margin = 0;                    ///< share of those pixels within the strip along silhouettes
  /// Share of the face's samples that see it; kWholeShare if its class is full; 0 if the photo shows background there
  /// (labeling/background.h) or a mixture with it, and then nothing else is set but the margin, whole for a mixture.
  Share16 visible = 0;
  /// With the face's other photos: fixed_distance(). Until these are compared, it holds steps().
  std::uint16_t disagreement = 0;
  std::uint16_t contrast = 0;  ///< standard deviation of those pixels' brightness, in grey levels times 256
  std::uint16_t pixels = 0;    ///< how many those are; 65535 stands for more, too
  /// Until photos are compared: root mean square of the brightness steps from those pixels to the ones before them in the row, in
  /// grey levels times 256.
  std::uint16_t steps() const { return disagreement; }
  bool is_full() const { return visible == kWholeShare; }
  bool has_surface() const { return visible != 0; }
  bool is_mixed() const { return margin == kWholeShare; }  ///< if it has no surface
};
static_assert(sizeof(FaceRecord) == 24);

}  // namespace gpvc::labeling
