// Coverage of partial faces, collected over the views. Which faces need theirs is known only after the last view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "labeling/labeling.h"
#include "visibility/visibility.h"

namespace gpvc::pipeline {

/// Coverage with bits run-length encoded by words. Faces as large as photos have megabytes of them a view, most words of
/// which are all 0 or all 1.
struct PackedCoverage {
  std::vector<visibility::FaceCoverage> entries;  ///< first_word: into runs
  std::vector<std::uint64_t> runs;
};

PackedCoverage pack(const visibility::CoverageTable& coverage);

class CoverageStore {
 public:
  void add(const PackedCoverage& coverage);
  /// The coverage of faces tagged partial, as it was added. Other faces take their texels from one view and need none.
  visibility::CoverageTable of_partial_faces(std::span<const labeling::FaceTag> tags) const;
  const PackedCoverage& all() const { return all_; }
  std::size_t bytes() const {
    return all_.runs.size() * sizeof(std::uint64_t) + all_.entries.size() * sizeof(visibility::FaceCoverage);
  }

 private:
  PackedCoverage all_;
};

}  // namespace gpvc::pipeline
