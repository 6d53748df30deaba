// The steps of texturing, as the commands string them together: what the views see, one view per face, the atlas. Each
// is a stage on the console and in the record.
#pragma once

#include <cstddef>
#include <functional>

#include "app/cli/options.h"
#include "app/cli/run_record.h"
#include "app/cli/scene_input.h"

namespace gpvc::pipeline {

/// Photos are decoded once where they fit: a quarter of the memory, a gigabyte at most.
std::size_t photo_cache_bytes();

/// Adjacency of the faces, weighed as options.edge_weights says.
labeling::FaceGraph weighed_graph(const Mesh& mesh, const cli::TextureOptions& options, cli::Console& console,
                                  cli::RunRecord& record);

/// Seconds over all views.
struct ViewTimes {
  double render_s = 0, build_s = 0, upload_s = 0, readback_s = 0, classify_s = 0, costs_s = 0;
};

struct SeenScene {
  labeling::Candidates candidates;
  visibility::CoverageTable coverage;  ///< of faces tagged partial
  std::size_t full = 0, partial = 0;   ///< pairs of view and face
  ViewTimes times;
};

/// Called for each view once it is classified, on the caller's thread.
using ViewObserver = std::function<void(ViewId, const visibility::ViewVisibility&)>;

/// View after view: while the device draws one, the costs of the one before are taken and the next photo is decoded.
/// Throws GpuError, InputError, Cancelled.
SeenScene see_views(const cli::SceneInputData& in, io::PhotoSource& photos, visibility::GraphicsDevice& device,
                    const cli::TextureOptions& options, cli::Console& console, cli::RunRecord& record,
                    const ViewObserver& observe = {});

/// What the tags say, and a word where hardly anything is seen: cameras and mesh in two frames. Throws InputError where
/// nothing is.
void count_tags(const labeling::Candidates& candidates, const std::filesystem::path& mesh, cli::Console& console,
                cli::RunRecord& record);

labeling::Selection choose_views(const SeenScene& seen, const labeling::FaceGraph& graph,
                                 const cli::TextureOptions& options, cli::Console& console, cli::RunRecord& record);

atlas::TextureAtlas make_atlas(const atlas::AtlasInput& input, const cli::TextureOptions& options,
                               cli::Console& console, cli::RunRecord& record);

}  // namespace gpvc::pipeline
