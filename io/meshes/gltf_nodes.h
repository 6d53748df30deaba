// The nodes of a glTF's scene: what they show, and where.
#pragma once

#include <array>
#include <filesystem>
#include <functional>

#include "io/meshes/gltf_reader.h"

namespace gpvc::io {

/// 4 x 4, column after column, as glTF has them.
using GltfMatrix = std::array<double, 16>;

/// What becomes of the offset of a node of ours (offset_of): it moves what the node holds, or is left to the caller.
enum class GltfOffset { added, left };

/// Calls `add` with each primitive that the file's scene shows, in the order of its nodes, and the matrix that places it:
/// all that the nodes above it move, turn and scale. A node of ours keeps the axes of the mesh that it was made from, so its
/// rotation is none. Throws InputError for nodes that are no tree.
void for_each_primitive(const std::filesystem::path& file, const tinygltf::Model& model, GltfOffset offset,
                        const std::function<void(const tinygltf::Primitive&, const GltfMatrix& world)>& add);

/// Where an element of a primitive's positions lies.
WorldPoint placed(const GltfMatrix& world, const AccessorView& positions, std::size_t element);

/// True if triangles that are placed so are turned over.
bool mirrors(const GltfMatrix& world);

}  // namespace gpvc::io
