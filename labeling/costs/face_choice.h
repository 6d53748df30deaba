// The candidates among the views of one face, and what they cost.
#pragma once

#include <span>
#include <vector>

#include "labeling/costs/face_records.h"
#include "labeling/labeling.h"
#include "labeling/view_choice.h"

namespace gpvc::labeling {

/// The candidates of one face.
struct FaceChoice {
  std::vector<ViewRecord> taken;
  std::vector<float> quality;  ///< of the taken views
  FaceTag tag = FaceTag::unseen;
  std::size_t rejected = 0;
};

/// Decides between full and partial views, and leaves outliers out. Reuses the memory of `choice`.
void choose(std::span<const ViewRecord> records, const CostOptions& options, FaceChoice& choice);

/// \param quality of the view \param best of all candidates
CostParts cost_of(const FaceRecord& record, float quality, float best, const CostOptions& options);

}  // namespace gpvc::labeling
