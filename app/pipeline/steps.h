// What texture_into(), retexture_into(), tileset::tileset_into() and the units of jobs share of the steps.
#pragma once

#include <cstdint>
#include <future>
#include <vector>

#include "app/pipeline/pipeline.h"

namespace gpvc::pipeline {

/// How work beside other work is started: a run that is limited to one thread does it on that.
std::launch launch_policy();

/// Per view the first that shows the same photo; empty where each has its own.
std::vector<std::uint32_t> photo_of_view(const Scene& scene);

/// What the atlas is made from.
struct Choice {
  labeling::FaceGraph graph;
  Seen seen;
  labeling::Selection selection;
};
/// The stages up to view selection, within the memory.
Choice see_and_choose(const Input& input, const Settings& settings, const MemoryPlan& memory, io::PhotoSource& photos,
                      Observer& observer, SeeOptions options = {});

/// Notes the figures of a selection and ends the stage. \param origin added to what the stage says
void report_selection(const labeling::Selection& selection, const char* origin, Observer& observer);

/// Within the stage "atlas".
atlas::AtlasPlan plan_and_note(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer);

/// Shares the memory between pages, partial charts and photos.
atlas::BakeOptions bake_options(const atlas::AtlasPlan& plan, const Settings& settings, const MemoryPlan& memory,
                                io::PhotoSource& photos);

/// Ends the stage "atlas".
atlas::TextureAtlas bake_and_end(const atlas::AtlasPlan& plan, const atlas::AtlasInput& input,
                                 const atlas::AtlasOptions& options, Observer& observer,
                                 const atlas::BakeOptions& memory = {});

}  // namespace gpvc::pipeline
