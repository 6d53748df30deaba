// What texture_into(), retexture_into(), tileset::tileset_into() and the units of jobs share of the steps.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "../checks/scene_fit.h"
#include "pipeline.h"

namespace gpvc::pipeline {

class CoverageStore;

/// Per view the first that shows the same photo; empty where each has its own.
std::vector<std::uint32_t> photo_of_view(const Scene& scene);

/// True for the methods whose classes are right; the methods that gpvc is compared with also see faces that are hidden.
bool is_exact(const visibility::Method& method);
checks::Tolerance tolerance_of(const Settings& settings);

/// The labels that the run has kept; nullopt: none, or of another mesh.
std::optional<labeling::Selection> kept_labels(const Run& run);

/// Called once all photos are compared with each other, before rules about them are applied.
using OnJudged = std::function<void(const labeling::CandidateCollector&, const CoverageStore&)>;
Seen see(const Run& run, const SeeOptions& options, const OnJudged& on_judged);

/// What the atlas is made from.
struct Choice {
  labeling::FaceGraph graph;
  Seen seen;
  labeling::Selection selection;
};
/// The stages up to the choice of views, within the memory. \param labels per face the view that it takes if that is one of its
/// candidates, kNoView where one is to be chosen, as elsewhere; empty: chosen for all. \pre not labels and work that is kept
Choice see_and_choose(const Run& run, const MemoryPlan& memory, SeeOptions options = {}, const OnJudged& on_judged = {},
                      std::span<const ViewId> labels = {});

/// Notes the figures of a selection and ends the stage. \param origin added to what the stage says
void report_selection(const labeling::Selection& selection, const char* origin, Observer& observer);

}  // namespace gpvc::pipeline
