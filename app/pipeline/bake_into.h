// Bakes an atlas within a run's memory and hands its pages on: what textured models, changed ones, tilesets and jobs share.
#pragma once

#include <filesystem>
#include <string>

#include "../../atlas/atlas.h"
#include "../../io/photos.h"
#include "memory.h"
#include "page_sink.h"
#include "run.h"

namespace gpvc::pipeline {

/// What baking may use beside the memory.
struct BakeSpace {
  std::string stage = "bake";  ///< as the observer sees it
  std::filesystem::path scratch_folder = {};
  atlas::KeptPages kept = {};
};

/// The run's photos with coarse ones beside them, where baking needs any. They are kept in the folder, in at most half of the
/// space on its disk that a result of `likely` bytes leaves free.
io::CoarsePhotos with_coarse_photos(const Run& run, const Workload& work, double likely,
                                    const std::filesystem::path& folder);

/// Figures of how photos were aligned, and a note where their poses are to blame.
void report_alignment(const atlas::AlignmentStatistics& alignment, Observer& observer);

/// One stage. Without a sink the atlas holds its pages.
atlas::TextureAtlas bake_into(const Run& run, const atlas::AtlasInput& from, const MemoryPlan& memory,
                              const BakeSpace& space, PageSink* sink);

/// Its parts, within the stage.
atlas::AtlasPlan plan_and_note(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer);
/// Ends the stage.
atlas::TextureAtlas bake_and_end(const atlas::AtlasPlan& plan, const atlas::AtlasInput& input,
                                 const atlas::AtlasOptions& options, Observer& observer,
                                 const atlas::BakeOptions& memory = {});

}  // namespace gpvc::pipeline
