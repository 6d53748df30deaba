// From one view per face to texture pages: charts, packing, seam leveling, baking.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/io.h"
#include "io/scene.h"
#include "labeling/labeling.h"
#include "visibility/visibility.h"

namespace gpvc {

enum class SeamLeveling { none, global, full };

struct AtlasOptions {
  int page_size = 8192;  ///< largest page edge, texels; pages are cropped to their content
  int padding = 8;       ///< texels around a chart that carry extended colour
  SeamLeveling seams = SeamLeveling::full;
  /// Texels of partial faces prefer views in which nothing hides the face within this many pixels: photo and
  /// mesh disagree by a few pixels along silhouettes.
  int margin_px = 3;
};

struct AtlasStatistics {
  std::size_t charts = 0, filled_faces = 0;
  std::size_t chart_texels = 0;  ///< inside charts, padding not counted
  std::size_t page_texels = 0;   ///< of all pages after cropping
  std::size_t seam_edges = 0;    ///< mesh edges between faces of different views
  double seam_step_before = 0,
         seam_step_after = 0;  ///< mean grey-level step across seams (0..255); zero without leveling
  double layout_s = 0, leveling_s = 0, baking_s = 0;
};

struct TextureAtlas {
  TexturedModel model;       ///< every input face has texture coordinates
  std::vector<Image> pages;  ///< RGB
  AtlasStatistics statistics;
};

/// What the atlas is made from; all borrowed.
struct AtlasInput {
  const Mesh& mesh;
  const Scene& scene;
  PhotoCache& photos;
  const FaceGraph& graph;
  std::span<const ViewId> labels;  ///< per face; kNoView = no view, filled from the surroundings
  std::span<const FaceTag> tags;   ///< per face
  const CostTable& candidates;     ///< for partial faces: the views that may contribute texels, by cost
  const CoverageTable& coverage;   ///< which pixels of those views see the partial faces
};

/// Charts are faces of one view, connected or so close in its photo that their paddings would overlap; their
/// texture coordinates are the exact projections into that view's undistorted frame, so photo texels are
/// copied at full resolution. Faces tagged partial take each texel from the best view whose coverage shows
/// it. Each photo is fetched from the cache at most twice, once for its seams and once to bake. Throws
/// InputError from photos and std::invalid_argument where options and input do not fit together. Progress
/// counts photos baked.
TextureAtlas build_atlas(const AtlasInput& input, const AtlasOptions& options, const Progress& progress);

}  // namespace gpvc
