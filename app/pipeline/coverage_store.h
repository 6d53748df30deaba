// Coverage of partial faces, collected over the views. Which faces need theirs is known only after the last view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "../../labeling/labeling.h"
#include "../../visibility/result.h"

namespace gpvc::pipeline {

/// The coverage of one view, some 20 bytes for a face of a few pixels. Bits of large faces are run-length encoded by words:
/// faces as large as photos have megabytes of them, most words of which are all 0 or all 1.
struct PackedCoverage {
  ViewId view{};
  std::vector<std::uint8_t> bytes;
};

/// \pre all entries are of the view, in face order
PackedCoverage pack(ViewId view, const visibility::CoverageTable& coverage);

/// True if pack() may have made it of what the view sees of the mesh: CoverageStore reads no other one safely. A few bytes can
/// stand for a box as large as a photo, so each box has to lie around its face's projection: what all of them take unpacked is
/// then no more than what looking at the view takes. O(bytes).
bool is_sound(const PackedCoverage& packed, const Mesh& mesh, const View& view);

class CoverageStore {
 public:
  void add(std::shared_ptr<const PackedCoverage> coverage) { views_.push_back(std::move(coverage)); }
  /// The coverage of faces tagged partial, as it was added. Other faces take their texels from one view and need none.
  visibility::CoverageTable of_partial_faces(std::span<const labeling::FaceTag> tags) const;
  std::span<const std::shared_ptr<const PackedCoverage>> views() const { return views_; }
  double bytes() const;

 private:
  std::vector<std::shared_ptr<const PackedCoverage>> views_;
};

}  // namespace gpvc::pipeline
