// How well a textured model, ours or another program's, reproduces photos.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/evaluate/rephotography.h"
#include "io/photos.h"
#include "io/progress.h"
#include "io/textured_model.h"

namespace gpvc::evaluate {

struct EvaluateOptions {
  std::filesystem::path model;                ///< OBJ or GLB
  std::optional<std::filesystem::path> mesh;  ///< the faces to be textured; default: the model's
  std::optional<std::filesystem::path> out;   ///< folder for pictures (photo, render, error) and evaluate.json
  int reduction = 4;                          ///< photos and renders are compared at 1/reduction of their size
};

struct ViewScore {
  std::string view;
  RephotographyScore score;
};

struct Evaluation {
  std::vector<ViewScore> views;
  RephotographyScore mean;
};

/// Renders the model from every view of `scene` and compares the renders with the photos. Views without a comparable
/// window are listed and left out of the mean. Throws InputError, OutputError.
Evaluation evaluate_model(const Scene& scene, io::PhotoSource& photos, const EvaluateOptions& options,
                          const Progress& progress);

/// read_textured_model(), which also throws InputError for a model without a textured face.
io::LoadedModel read_model_with_texture(const std::filesystem::path& file);

/// A table for people, one line a view and the mean.
std::string evaluation_table(const Evaluation& evaluation);

}  // namespace gpvc::evaluate
