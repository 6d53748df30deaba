// The steps of texturing, as the commands string them together: what the views see, one view per face, the atlas. Each
// is a stage on the console and in the record.
#pragma once

#include <cstddef>
#include <functional>

#include "app/options.h"
#include "app/run_record.h"
#include "app/scene_input.h"

namespace gpvc {

/// Photos are decoded once where they fit: a quarter of the memory, a gigabyte at most.
std::size_t photo_cache_bytes();

/// Adjacency of the faces, weighed as options.edge_weights says.
FaceGraph weighed_graph(const Mesh& mesh, const TextureOptions& options, Console& console, RunRecord& record);

/// Seconds over all views.
struct ViewTimes {
  double render_s = 0, build_s = 0, upload_s = 0, readback_s = 0, classify_s = 0, costs_s = 0;
};

struct SeenScene {
  Candidates candidates;
  CoverageTable coverage;             ///< of faces tagged partial
  std::size_t full = 0, partial = 0;  ///< pairs of view and face
  ViewTimes times;
};

/// Called for each view once it is classified, on the caller's thread.
using ViewObserver = std::function<void(ViewId, const ViewVisibility&)>;

/// View after view: while the device draws one, the costs of the one before are taken and the next photo is decoded.
/// Throws GpuError, InputError, Cancelled.
SeenScene see_views(const SceneInputData& in, PhotoCache& photos, GraphicsDevice& device, const TextureOptions& options,
                    Console& console, RunRecord& record, const ViewObserver& observe = {});

/// What the tags say, and a word where hardly anything is seen: cameras and mesh in two frames. Throws InputError where
/// nothing is.
void count_tags(const Candidates& candidates, const std::filesystem::path& mesh, Console& console, RunRecord& record);

Selection choose_views(const SeenScene& seen, const FaceGraph& graph, const TextureOptions& options, Console& console,
                       RunRecord& record);

TextureAtlas make_atlas(const AtlasInput& input, const TextureOptions& options, Console& console, RunRecord& record);

}  // namespace gpvc
