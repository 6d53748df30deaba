// The files of a textured model.
#pragma once

#include "app/options.h"
#include "app/output_folder.h"
#include "app/run_record.h"
#include "app/scene_input.h"

namespace gpvc {

struct TexturedScene {
  const SceneInputData& input;
  const Selection& selection;
  const Candidates& candidates;
  const TextureAtlas& atlas;
};

/// Writes everything but run.json: pages, OBJ, GLB and the arrays on other threads while the preview is drawn on this
/// one, the device's. Throws OutputError, GpuError, Cancelled.
void write_textured_scene(const TexturedScene& scene, const TextureOptions& options, GraphicsDevice& device,
                          OutputFolder& folder, Console& console, RunRecord& record);

}  // namespace gpvc
