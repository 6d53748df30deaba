// How well a textured model, ours or another program's, reproduces photos.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/evaluate/rephotography.h"
#include "io/error.h"
#include "io/photos.h"
#include "io/progress.h"
#include "io/textured_model.h"

namespace gpvc::evaluate {

struct EvaluateOptions {
  std::filesystem::path model;               ///< the model's file, for messages
  const Mesh* mesh = nullptr;                ///< borrowed; the faces to be textured, null: the model's
  std::optional<std::filesystem::path> out;  ///< folder for pictures (photo, render, error) and evaluate.json
  int reduction = 4;                         ///< photos and renders are compared at 1/reduction of their size
};

struct ViewScore {
  std::string view;
  RephotographyScore score;
};

struct BandScore {
  std::string band;
  RephotographyScore mean;  ///< over the views, of the band as a grey picture in the range of what is looked at
  double rms = 0;           ///< of the differences from the photos, in the band's unit, without a gain
};

struct Evaluation {
  std::vector<ViewScore> views;
  RephotographyScore mean;
  std::vector<BandScore> bands{};  ///< none where the photos, or the model's pages, have no samples
};

/// Renders the model from every view of `scene` and compares the renders with the photos. Views without a comparable
/// window are listed, and count in the mean by their completeness alone. Throws InputError, OutputError.
/// \pre model.model.mesh is &model.mesh; model and mesh lie in the scene's coordinates, see place_model()
Evaluation evaluate_model(const Scene& scene, io::PhotoSource& photos, const io::LoadedModel& model,
                          const EvaluateOptions& options, const Progress& progress);

/// Brings a model into the scene's coordinates or the cameras to it, as checks::match_frames() does with a mesh, by its
/// own file or, where that says nothing, by the file of the mesh that it was made from (empty: none).
/// A model that fits the cameras as it is stays there even with `mesh_crs`: tiles have the scene's coordinates. Remarks
/// what was assumed. Throws what match_frames() throws.
Remark place_model(const std::filesystem::path& file, const std::filesystem::path& mesh_file,
                   const std::string& mesh_crs, std::span<const ViewId> used, Scene& scene, io::LoadedModel& model);

/// read_textured_model(), which also throws InputError for a model without a textured face.
io::LoadedModel read_model_with_texture(const std::filesystem::path& file);

/// What is wrong where no view of a model has a window to compare: the end of a sentence.
inline constexpr const char* kNothingToCompare =
    "no view shows enough of it to compare; is it in the cameras' coordinates?";

/// A table for people, one line a view and the mean.
std::string evaluation_table(const Evaluation& evaluation);

}  // namespace gpvc::evaluate
