// What one photo shows of every face that its view sees, from one pass over the item buffer.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/io.h"
#include "io/scene.h"
#include "labeling/labeling.h"
#include "visibility/visibility.h"

namespace gpvc::labeling {

/// A share in [0, 1] in steps of 1/65535, both ends exact.
using Share16 = std::uint16_t;
inline constexpr Share16 kWholeShare = 65535;
Share16 share16(double share);

/// One face in one view: 20 bytes, since a scene has tens of millions of them.
struct FaceRecord {
  std::uint32_t face = 0;
  float quality = 0;                     ///< of the data term chosen, >= 0, more is better; px^2 or grey levels px
  std::array<std::uint16_t, 3> color{};  ///< mean R, G, B of the pixels that show the face, times 256
  Share16 margin = 0;                    ///< of those pixels, the share within the silhouette margin
  Share16 visible = 0;                   ///< share of the face's samples that see it; whole when class is full
  std::uint16_t disagreement = 0;        ///< with the other photos of the face: fixed_distance()
  bool is_full() const { return visible == kWholeShare; }
};
static_assert(sizeof(FaceRecord) == 20);

/// Records of the full and partial faces, in face order. O(faces + pixels), TBB inside, sums in integers: the same for
/// any number of threads. Quality: `area`: projected pixels, times the visible share. `gmi`: that times the mean
/// gradient magnitude over the face's pixels, in grey levels a pixel (the integral of the gradient magnitude over the
/// projection; area and mean apart, because a face of a few pixels covers no exact number of centres). `gmi_angle`:
/// that times cos^2 of the angle between the face's normal and the line of sight. A face without a pixel in the item
/// buffer is looked up at its centroid.
std::vector<FaceRecord> view_statistics(const Mesh& mesh, const View& view, const Image& photo,
                                        const visibility::ViewVisibility& visibility, const CostOptions& options);

}  // namespace gpvc::labeling
