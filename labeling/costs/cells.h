// The mesh in cells of some seven pixels across, and what each view shows of them: colours that noise and a pixel of
// misregistration change little, and places at which photos can be compared in their structure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/grouping.h"
#include "labeling/costs/face_records.h"
#include "labeling/costs/photo_colors.h"

namespace gpvc::labeling {

/// Pixels of a cell. Smaller ones find thinner things, and compare colours that scatter more.
inline constexpr float kCellPixels = 48;

inline constexpr std::uint32_t kNoCell = 0xFFFFFFFFu;

/// Connected clusters of nodes.
struct Clusters {
  std::vector<std::uint32_t> of_node;  ///< kNoCell for nodes of size 0
  std::uint32_t count = 0;
};

/// Breadth-first pieces, in the order of their lowest nodes, that grow until their sizes add up to `wanted`. Pieces of less
/// than half of that, which are left over between others, join one of these. O(nodes + pairs).
Clusters make_clusters(const Grouped<std::uint32_t>& neighbours, std::span<const float> sizes, float wanted);

/// Per cluster, those that have nodes beside its own. O(pairs * log(pairs)).
Grouped<std::uint32_t> clusters_beside(const Clusters& clusters, const Grouped<std::uint32_t>& neighbours);

/// Parts that a cell's faces are put together to, the same in all views.
inline constexpr std::size_t kCellParts = 8;
inline constexpr std::uint8_t kAllParts = (1U << kCellParts) - 1;

/// A cell in a view that sees half of its faces whole at least. Colours are in grey levels, without the photo's gain.
struct CellSight {
  std::uint32_t view = 0;
  std::array<float, 3> rgb{};  ///< mean
  float log_contrast = 0;  ///< logarithm to base 2 of kNoContrast + the standard deviation of the pixels' brightness
  float pixels = 0;        ///< that show the cell
  float steps = 0;         ///< mean square of FaceRecord::steps(), in grey levels
  std::uint8_t shown = 0;  ///< a bit for each part
  std::uint8_t shown_parts = 0;                                 ///< how many those are
  std::array<std::array<std::uint8_t, 3>, kCellParts> parts{};  ///< mean colours; 0 of others than those
  // Sums over the parts, as a sight is compared with many others.
  std::array<std::uint16_t, 3> part_levels{};
  std::uint32_t part_squares = 0;  ///< of all channels
  bool shows_all() const { return shown == kAllParts; }
};
static_assert(sizeof(CellSight) == 64);
/// Grey levels below which noise dominates the contrast.
inline constexpr float kNoContrast = 4;

struct Cells {
  std::vector<std::uint32_t> of_face;  ///< kNoCell for faces that no view sees whole
  Grouped<std::uint32_t> beside;       ///< per cell, those it shares edges of faces with
  Grouped<CellSight> sights;           ///< by cell, views ascending
  std::size_t count() const { return sights.groups(); }
};

/// A cell has so many sights at most, those of the most pixels, because all pairs of them are compared. Further views show the cell
/// smaller, and are seldom chosen.
inline constexpr std::size_t kMostSights = 256;

/// Where faces are larger than cells, each is a cell of one part. \param neighbours of all faces. O(records), TBB; the
/// result does not depend on the number of threads.
Cells make_cells(const RecordsByView& by_view, const PhotoColors& colors, const Grouped<std::uint32_t>& neighbours);

}  // namespace gpvc::labeling
