// The photos that faces of a glTF show, for readers that know EXT_mesh_features and EXT_structural_metadata: each vertex has the
// number of a feature, which is a row of a table. All corners of a triangle have the same one, so that it can be picked.
// https://github.com/CesiumGS/glTF/tree/3d-tiles-next/extensions/2.0/Vendor/EXT_structural_metadata
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "io/textured_model.h"

namespace gpvc::io {

inline constexpr const char* kMeshFeatures = "EXT_mesh_features";
inline constexpr const char* kStructuralMetadata = "EXT_structural_metadata";
/// The vertices' attribute with the number of their row.
inline constexpr const char* kFeatureAttribute = "_FEATURE_ID_0";

/// The table's columns as they stand in a buffer, one after another.
std::string photo_columns(const PhotoTable& photos);

/// Describes the table, whose columns begin at `offset` of a buffer.
void describe_photos(nlohmann::json& gltf, const PhotoTable& photos, std::size_t buffer, std::size_t offset);

/// The extension of a primitive with the attribute.
nlohmann::json photo_features(const PhotoTable& photos);

}  // namespace gpvc::io
