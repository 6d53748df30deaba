// What the writers of scene formats share, and the formats that are JSON.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "io/scene_files.h"
#include "io/scenes/colmap_models.h"

namespace gpvc::io {

/// A view to be written.
struct PlacedView {
  const View& view;
  const std::filesystem::path& place;  ///< of its photo, see photo_places()
  std::uint32_t camera;                ///< which of PlacedScene::cameras it has
};

/// What write_scene() writes.
struct PlacedScene {
  const Scene& scene;
  const std::filesystem::path& folder;
  std::vector<PlacedView> views{};
  std::vector<Camera> cameras{};  ///< of these views, each once, in the order of their first use
};

/// t of x_camera = R x_world + t.
WorldPoint translation(const Pose& pose);

/// The first term of the lens that is not zero and not among those `stated`.
std::optional<std::string> first_term_beyond(const Distortion& d, std::span<const DistortionTerm> stated);

/// "the equisolid (fisheye) projection"
std::string projection_name(LensModel model);

inline bool is_perspective(LensModel model) { return model == LensModel::brown || model == LensModel::perspective; }

/// masks/NAME.EXT.png of images/NAME.EXT.
std::filesystem::path mask_in_folder(const std::filesystem::path& photo);

// SceneWriter::lost_term and SceneWriter::write of the formats that are JSON; names that are not UTF-8 are an OutputError.
std::optional<std::string> lost_in_transforms(const Camera& camera);
std::optional<std::string> lost_in_opensfm(const Camera& camera);
void write_transforms(const PlacedScene& scene);
void write_opensfm(const PlacedScene& scene);

}  // namespace gpvc::io
