// What the parts of the accuracy benchmark share: scenes with the oracle's classes, modes, scores.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/table.h"
#include "visibility/method.h"
#include "visibility/oracle.h"

namespace gpvc::accuracy {

/// A mesh and a view, with the oracle's classes.
struct TrueScene {
  std::string name;
  Mesh mesh;
  View view;
  visibility::OracleView truth;
};

TrueScene with_truth(std::string name, Mesh mesh, View view);

/// How many faces a mode calls fully visible, and how many it gets right. "Visible" is class full, "occluded"
/// everything else, as in the paper's tables; ties count as right.
struct Score {
  std::size_t visible = 0, occluded = 0, right = 0;
  std::size_t wrong_classes = 0;  ///< untied faces whose class is not exactly the oracle's
  double percent() const { return 100.0 * static_cast<double>(right) / static_cast<double>(visible + occluded); }
  bool operator==(const Score&) const = default;
};

Score score(visibility::GraphicsDevice& device, const TrueScene& scene, const visibility::VisibilityOptions& options);

/// The item buffer of a scene's view as the options draw it.
visibility::Ivm drawn(visibility::GraphicsDevice& device, const TrueScene& scene,
                      const visibility::VisibilityOptions& options);

/// Writes a picture of two layers, each of a colour that varies from face to face. Throws OutputError.
void write_layers(const std::filesystem::path& file, const visibility::Ivm& ivm, bool (*is_upper)(std::size_t face));

/// Options of a mode by name, with all else at its default. Throws std::invalid_argument.
visibility::VisibilityOptions mode(const std::string& name);

/// 0.1, halved down to 1e-13: 40 values; every `step`th of them.
std::vector<double> epsilons(std::size_t step);

struct Setup {
  visibility::GraphicsDevice& device;
  std::filesystem::path folder;  ///< for CSV files and pictures, or empty; exists
  bool quick = false;
};

struct Part {
  std::string markdown;
  /// gpvc with the exact correction erred nowhere, nor did LPCC on the paper's models; figure 15 shows its effect.
  bool as_expected = true;
};

/// Tables 1 to 6: the models A, B, C. Throws std::logic_error when a model is not what the paper says of it.
Part paper_tables(const Setup& setup);

/// Figure 15: layers some millimetres apart at 100 m, drawn with symmetric and with reversed depth.
Part depth_table(const Setup& setup);

/// Layers 1 m to 10 um apart, 10 m to 10 km away, at three places of the world.
Part layer_table(const Setup& setup);

}  // namespace gpvc::accuracy
