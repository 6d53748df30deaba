// Scenes, cameras and devices as JSON: views.json, and parts of run.json and reports.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "app/evaluate/json.h"
#include "io/scene.h"
#include "visibility/device.h"

namespace gpvc::evaluate {

/// [x, y, z].
Json point_json(const WorldPoint& p);

/// The model and its terms: the five of OpenCV always, the others where the model has them.
Json lens_json(const Distortion& lens);

/// "k1 -0.1 p2 0.003": the terms that are not zero; "" for none.
std::string lens_text(const Distortion& lens);

/// Size, intrinsics and lens of a camera in pixels, its rotation as three rows, and its centre in world coordinates.
Json camera_json(const Camera& camera, const Pose& pose);

/// null without a device.
Json device_json(const std::optional<visibility::DeviceInfo>& device);

/// Writes views.json: every view in order, with `used` and `held_out`. Both lists are ascending. Throws OutputError.
void write_views_json(const std::filesystem::path& file, const Scene& scene, std::span<const ViewId> used,
                      std::span<const ViewId> held_out);

}  // namespace gpvc::evaluate
