// The models of a comparison rendered from photos' viewpoints: scored against the photos, and kept for the crops.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "app/cli/run_record.h"
#include "app/evaluate/rephotography.h"
#include "io/photos.h"
#include "io/progress.h"
#include "io/textured_model.h"

namespace gpvc::compare {

/// A place that the modes show differently, cut from the photo and from each model's render.
struct Crop {
  std::string view;
  int x = 0, y = 0, width = 0, height = 0;  ///< in the view's undistorted frame
  double disagreement = 0;                  ///< mean deviation of the models from one another, grey levels
  Image photo;
  std::vector<Image> renders;  ///< of the models, in the order they were shown
  std::vector<double>
      errors;  ///< per model: mean difference from the photo where the mesh is, after a gain, grey levels
};

struct ModelViewsOptions {
  std::vector<ViewId> scored, cropped;  ///< ascending
  int reduction = 4;
  std::filesystem::path renders;  ///< an existing folder for renders until the crops are cut
};

/// How much lower one model's mean 1 - NCC is than another's, with its standard error.
struct ErrorDifference {
  double less = 0;
  double noise = 0;  ///< one standard error
  bool known = false;
};

class ModelViews {
 public:
  /// Borrows all. Draws the mesh once from each scored view. Keeps a few bytes a pixel of each scored view.
  ModelViews(const Mesh& mesh, const Scene& scene, io::PhotoSource& photos, ModelViewsOptions options,
             const Progress& progress);

  /// Renders a model from every view, keeps the renders of the cropped ones, returns the mean score over the scored
  /// ones. `offset` is to be added to the model's positions.
  evaluate::RephotographyScore show(const io::TexturedModel& model, const std::vector<Image>& pages,
                                    const WorldPoint& offset, const Progress& progress);

  /// Models count in the order they were shown. The standard error is that of the mean, over views, of paired
  /// differences, with the kErrorTiles x kErrorTiles tiles of each view taken as a random sample. Tiles of several views
  /// may show the same place and depend on each other, so it is rather too small.
  ErrorDifference difference(std::size_t model, std::size_t from) const;

  /// The windows in which the models shown so far differ most, at most `count`, two of a view until all views have
  /// theirs.
  std::vector<Crop> crops(std::size_t count) const;

 private:
  struct Frame {
    Image photo;
    std::vector<std::uint8_t> inside, covered;
  };
  struct Window {
    std::size_t view = 0;  ///< index into cropped
    int x = 0, y = 0, width = 0, height = 0;
    double disagreement = 0;
  };
  std::filesystem::path render_file(std::size_t model, std::size_t view) const;
  std::vector<Window> windows(std::size_t view) const;
  Crop cut(const Window& window) const;

  const Scene& scene_;
  io::PhotoSource& photos_;
  ModelViewsOptions options_;
  std::vector<Frame> frames_;                                         ///< per scored view
  std::vector<std::vector<std::uint8_t>> covered_;                    ///< per cropped view
  std::vector<std::vector<Image>> thumbnails_;                        ///< per model shown and cropped view
  std::vector<std::vector<std::vector<evaluate::TileError>>> tiles_;  ///< per model shown and scored view
};

}  // namespace gpvc::compare
