// What the photos of a run tell of each face once they are compared with each other, for questions about single faces.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "../../labeling/labeling.h"
#include "run.h"

namespace gpvc::pipeline {

struct Judgement {
  /// Per view of the scene what CandidateCollector::statistics_of() gave once all photos were compared; empty where the view
  /// was not used, or was left out because it agrees with no other.
  std::vector<std::vector<std::byte>> statistics;
  std::vector<labeling::ViewAgreement> agreement;  ///< of the views that were used, ascending
  labeling::CostOptions costs;                     ///< by which views cost what they cost
  std::vector<ViewRule> rules;                     ///< about photos, by which views are refused
  std::vector<ViewId> labels;                      ///< per face the view that textures it; empty: none are chosen yet

  /// True if the view was left out as a whole.
  bool leaves_out(ViewId view) const;
};

/// Looks at all views, as see() does, with what that throws. O(views x (faces + pixels)).
Judgement judge(const Run& run);

/// That of an editable result (Settings::editable), with its costs, rules and labels, whatever the run's settings are. Throws
/// InputError where `from` holds none of this mesh, and these views and cameras. Photos are not read: their bytes may have
/// changed. O(faces + records).
Judgement read_judgement(const std::filesystem::path& from, const Run& run);

}  // namespace gpvc::pipeline
