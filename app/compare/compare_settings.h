// What `gpvc compare` is asked for.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/compare/compare_modes.h"
#include "app/pipeline/pipeline.h"

namespace gpvc::compare {

/// Another program's textured model of the same mesh.
struct ExternalModel {
  std::string name;
  std::filesystem::path file;
};

struct CompareSettings {
  pipeline::Settings texture;  ///< shared by all modes; its visibility is replaced by each mode's
  std::vector<ComparedMode> modes;
  std::vector<ExternalModel> externals;  ///< their names differ from the modes' and from "photo"
  std::string mesh_crs;  ///< of the mesh and of the externals where it is not the scene's; see match_frames()
  std::optional<std::filesystem::path> truth;  ///< a synthetic scene's folder; by default one that holds SCENE
  int crops = 8, crop_views = 6;
  int oracle_views = 3, score_views = 12;
  int reduction = 4;  ///< photos and renders are scored at 1/reduction of the size textured from
  bool keep_models = false;
};

}  // namespace gpvc::compare
