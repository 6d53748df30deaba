// Coverage of partial faces while views come in: only at the end is it known which faces need theirs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "labeling/labeling.h"
#include "visibility/visibility.h"

namespace gpvc::pipeline {

/// Bits are kept as runs of words: of faces as large as photos, some megabytes a view, most words are all 0 or all 1.
class CoverageStore {
 public:
  void add(const visibility::CoverageTable& coverage);
  /// The coverage of faces tagged partial, as it was added. What others have is of no use: those seen whole by some
  /// view are not pieced together.
  visibility::CoverageTable of_partial_faces(std::span<const labeling::FaceTag> tags) const;
  std::size_t bytes() const {
    return runs_.size() * sizeof(std::uint64_t) + entries_.size() * sizeof(visibility::FaceCoverage);
  }

 private:
  std::vector<visibility::FaceCoverage> entries_;  ///< first_word: into runs_
  std::vector<std::uint64_t> runs_;
};

}  // namespace gpvc::pipeline
