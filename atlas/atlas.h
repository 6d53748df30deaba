// From one view per face to texture pages: charts, packing, seam leveling, baking.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "../io/photos.h"
#include "../io/progress.h"
#include "../io/scene.h"
#include "../io/textured_model.h"
#include "../labeling/labeling.h"
#include "../visibility/visibility.h"

namespace gpvc::atlas {

enum class SeamLeveling { none, global, full };

/// What becomes of faces that no view shows: painted with the colours from around the hole, the same but left out where
/// the output can do without them, or painted in one colour.
enum class UnseenFaces { fill, drop, color };

struct AtlasOptions {
  int page_size = 8192;  ///< largest page edge, texels; pages are cropped to their content
  /// Texels around a chart that carry extended colour. With 8, mip levels down to 1/8 hold only one chart's colours
  /// wherever a face touches them: charts lie in blocks of 8 texels that they share with none (of the largest power of
  /// two up to the padding).
  int padding = 8;
  SeamLeveling seams = SeamLeveling::full;
  /// Texels of partial faces prefer views in which nothing hides the face within this many pixels: photo and mesh
  /// disagree by a few pixels along silhouettes.
  int margin_px = 3;
  /// Charts whose texels would be smaller than this, in world units, are reduced to it; 0: none. Steps of an eighth of
  /// an octave, never coarser.
  double texel_size = 0;
  /// Limits on pages and on their texels after cropping, met by one reduction of all charts; 0: none.
  std::size_t max_pages = 0, max_texels = 0;
  UnseenFaces unseen = UnseenFaces::fill;
  std::array<std::uint8_t, 3> unseen_color{128, 128, 128};
};

struct AtlasStatistics {
  std::size_t charts = 0, filled_faces = 0;
  std::size_t chart_texels = 0;   ///< inside charts, padding not counted
  std::size_t padded_texels = 0;  ///< inside charts or within the padding of one, each counted once
  std::size_t page_texels = 0;    ///< of all pages after cropping
  std::size_t seam_edges = 0;     ///< mesh edges between faces of different views
  /// Mean grey-level step across seams (0..255); not measured, and zero, without leveling.
  double seam_step_before = 0, seam_step_after = 0;
  double reduction = 1;  ///< of all charts, to meet the limits
  double layout_s = 0, leveling_s = 0, baking_s = 0;
};

struct TextureAtlas {
  io::TexturedModel model;   ///< every input face has texture coordinates
  std::vector<Image> pages;  ///< RGB
  AtlasStatistics statistics;
};

/// What the atlas is made from; all borrowed.
struct AtlasInput {
  const Mesh& mesh;
  const Scene& scene;
  io::PhotoSource& photos;
  const labeling::FaceGraph& graph;
  std::span<const ViewId> labels;             ///< per face; kNoView = no view, filled from the surroundings
  std::span<const labeling::FaceTag> tags;    ///< per face
  const labeling::CostTable& candidates;      ///< for partial faces: the views that may contribute texels, by cost
  const visibility::CoverageTable& coverage;  ///< which pixels of those views see the partial faces
};

/// What pages will take, before any photo is read.
struct AtlasEstimate {
  std::size_t charts = 0, pages = 0;
  std::size_t page_texels = 0;  ///< of all pages after cropping; exact
  double reduction = 1;         ///< of all charts, to meet the limits
};

/// Charts and where they lie on pages.
class AtlasPlan {
 public:
  struct State;
  explicit AtlasPlan(std::unique_ptr<State> state);
  ~AtlasPlan();
  AtlasPlan(AtlasPlan&&) noexcept;
  AtlasEstimate estimate() const;
  const State& state() const { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

/// Charts are faces of one view, connected or so close in its photo that their paddings would overlap; their texture
/// coordinates are the exact projections into that view's undistorted frame, so photo texels are copied at full
/// resolution. Faces tagged partial take each texel from the best view whose coverage shows it. Reads no photo. Throws
/// std::invalid_argument where options and input do not fit together, or where the smallest charts there can be exceed
/// a limit.
AtlasPlan plan_atlas(const AtlasInput& input, const AtlasOptions& options);

/// Levels and bakes. Each photo is fetched from the cache at most twice, once for its seams and once to bake. `input`
/// is what the plan was made from. Throws InputError from photos. Progress counts photos baked; it is called from any
/// thread, one at a time, also while a photo is baked, so that what it throws stops the work soon.
TextureAtlas bake_atlas(const AtlasPlan& plan, const AtlasInput& input, const Progress& progress);

/// Whose photos give a point of the texture its colour.
struct PointOrigin {
  ViewId first = kNoView;  ///< kNoView: nobody's; filled from around, or painted
  PixelPoint first_at;     ///< where in its undistorted frame
  /// Blended in with this share near the border to another view's texels; kNoView: nothing.
  ViewId second = kNoView;
  PixelPoint second_at;
  double second_share = 0;
};

/// What bake_atlas takes each point of the texture from, leveling aside: for measuring. Reads no photo.
class TextureOrigins {
 public:
  /// Borrows both. `input` is what the plan was made from. O(texels of partial faces x candidates), TBB; keeps some
  /// bytes for each of these texels.
  TextureOrigins(const AtlasPlan& plan, const AtlasInput& input);
  ~TextureOrigins();
  TextureOrigins(const TextureOrigins&) = delete;
  TextureOrigins& operator=(const TextureOrigins&) = delete;
  /// Of the point A + b (B - A) + c (C - A) of a face, by way of its texture coordinates.
  PointOrigin at(FaceId face, double b, double c) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// plan_atlas and bake_atlas in one.
TextureAtlas build_atlas(const AtlasInput& input, const AtlasOptions& options, const Progress& progress);

}  // namespace gpvc::atlas
