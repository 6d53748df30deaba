// What the writers of scene formats share, and the formats that are JSON.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "io/scene.h"
#include "io/scenes/colmap_models.h"

namespace gpvc::io {

/// t of x_camera = R x_world + t.
WorldPoint translation(const Pose& pose);

/// The first term of the lens that is not zero and not among those `stated`.
std::optional<std::string> first_term_beyond(const Distortion& d, std::span<const DistortionTerm> stated);

/// "the equisolid (fisheye) projection"
std::string projection_name(LensModel model);

inline bool is_perspective(LensModel model) { return model == LensModel::brown || model == LensModel::perspective; }

// The first thing of a lens that the format cannot state.
std::optional<std::string> lost_in_transforms(const Distortion& d);
std::optional<std::string> lost_in_opensfm(const Distortion& d);

/// transforms.json. `mask_of`: the place of the mask of a photo's place, if it has one. Throws OutputError, which names
/// `folder`, for names that are not UTF-8. \pre nothing is lost
std::string transforms_text(
    const std::filesystem::path& folder, const Scene& scene, std::span<const ViewId> used,
    std::span<const std::filesystem::path> places,
    const std::function<std::optional<std::filesystem::path>(const std::filesystem::path&)>& mask_of);

/// reconstruction.json, the same way. OpenSfM looks for masks by the photos' names.
std::string opensfm_text(const std::filesystem::path& folder, const Scene& scene, std::span<const ViewId> used,
                         std::span<const std::filesystem::path> places);

}  // namespace gpvc::io
