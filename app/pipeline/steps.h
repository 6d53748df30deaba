// What texture_into(), retexture_into() and tileset::tileset_into() share of the steps.
#pragma once

#include "app/pipeline/pipeline.h"

namespace gpvc::pipeline {

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
