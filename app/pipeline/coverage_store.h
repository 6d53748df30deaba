// Coverage of partial faces, collected over the views. Which faces need theirs is known only after the last view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "labeling/labeling.h"
#include "visibility/visibility.h"

namespace gpvc::pipeline {

/// Keeps the bits run-length encoded by words. Faces as large as photos have megabytes of them a view, most words of which
/// are all 0 or all 1.
class CoverageStore {
 public:
  void add(const visibility::CoverageTable& coverage);
  /// The coverage of faces tagged partial, as it was added. Other faces take their texels from one view and need none.
  visibility::CoverageTable of_partial_faces(std::span<const labeling::FaceTag> tags) const;
  std::size_t bytes() const {
    return runs_.size() * sizeof(std::uint64_t) + entries_.size() * sizeof(visibility::FaceCoverage);
  }

 private:
  std::vector<visibility::FaceCoverage> entries_;  ///< first_word: into runs_
  std::vector<std::uint64_t> runs_;
};

}  // namespace gpvc::pipeline
