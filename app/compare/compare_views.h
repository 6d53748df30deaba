// Models of a comparison rendered from photos' viewpoints: scored against the photos, and cut out where they differ.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/evaluate/rephotography.h"
#include "app/pipeline/pipeline.h"

namespace gpvc::compare {

/// A model as the views show it.
struct ShownModel {
  std::string name;
  evaluate::RephotographyScore score;                   ///< the mean over the scored views
  std::vector<std::vector<evaluate::TileError>> tiles;  ///< per scored view
  std::vector<std::filesystem::path> renders;           ///< per cropped view
  std::vector<Image> thumbnails;                        ///< per cropped view: luma, reduced
};

/// How much lower one model's mean 1 - NCC is than another's.
struct ErrorDifference {
  double less = 0;
  double noise = 0;  ///< one standard error
};

/// The standard error is that of the mean, over views, of paired differences, with the kErrorTiles x kErrorTiles tiles of
/// each view taken as a random sample. Tiles of several views may show the same place and depend on each other, so it is
/// rather too small. nullopt where no view scores both models.
std::optional<ErrorDifference> difference(const ShownModel& model, const ShownModel& from);

/// A place that the models show differently, cut from the photo and from each model's render.
struct Crop {
  std::string view;
  int x = 0, y = 0, width = 0, height = 0;  ///< in the view's undistorted frame
  double disagreement = 0;                  ///< mean deviation of the models from one another, grey levels
  Image photo;
  std::vector<Image> renders;  ///< per model
  std::vector<double>
      errors;  ///< per model: mean difference from the photo where the mesh is, after a gain, grey levels
};

struct ModelViewsOptions {
  std::vector<ViewId> scored, cropped;  ///< ascending
  int reduction = 4;
  std::filesystem::path renders;  ///< an existing folder for renders until the crops are cut
};

class ModelViews {
 public:
  /// Borrows what the input borrows, and the photos. Draws the mesh once from each scored view. Keeps a few bytes a pixel
  /// of each scored view.
  ModelViews(const checks::Input& input, io::PhotoSource& photos, ModelViewsOptions options, const Progress& progress);

  const std::vector<ViewId>& scored() const { return options_.scored; }

  /// Renders a model from every view and keeps the renders of the cropped ones in files, which carry its `number`.
  /// `offset` is to be added to the model's positions. The name is left to the caller.
  ShownModel show(std::size_t number, const io::TexturedModel& model, const std::vector<Image>& pages,
                  const WorldPoint& offset, const Progress& progress) const;

  /// The windows in which the models differ most, at most `count`, two of a view until all views have theirs.
  std::vector<Crop> crops(std::span<const ShownModel> models, std::size_t count) const;

 private:
  struct Window {
    std::size_t view = 0;  ///< index into cropped
    int x = 0, y = 0, width = 0, height = 0;
    double disagreement = 0;
  };
  const View& cropped_view(std::size_t n) const { return input_.scene.views[index(options_.cropped[n])]; }
  std::vector<Window> windows(std::span<const ShownModel> models, std::size_t view) const;
  Crop cut(std::span<const ShownModel> models, const Window& window) const;

  checks::Input input_;
  io::PhotoSource& photos_;
  ModelViewsOptions options_;
  std::vector<evaluate::ComparedPhoto> scored_photos_;
};

}  // namespace gpvc::compare
