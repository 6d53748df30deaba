// The files of a textured model.
#pragma once

#include "app/cli/options.h"
#include "app/cli/run_record.h"
#include "app/cli/scene_input.h"
#include "app/pipeline/output_folder.h"

namespace gpvc::pipeline {

struct TexturedScene {
  const cli::SceneInputData& input;
  const labeling::Selection& selection;
  const labeling::Candidates& candidates;
  const atlas::TextureAtlas& atlas;
};

/// Writes everything but run.json: pages, OBJ, GLB and the arrays on other threads while the preview is drawn on this
/// one. Throws OutputError, Cancelled.
void write_textured_scene(const TexturedScene& scene, const cli::TextureOptions& options, OutputFolder& folder,
                          cli::Console& console, cli::RunRecord& record);

}  // namespace gpvc::pipeline
