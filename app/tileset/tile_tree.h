// Meshes of a tileset: a quadtree over the ground, and its levels of detail.
//
// Level 0 has the faces of the input, divided among as many leaves as are needed, which have equally many; places in the tree
// that are left over are empty. A tile of level k + 1 takes the faces of its children, four at most, simplified to a quarter. The outer border of a tile keeps all of its
// vertices: the border between two tiles is simplified only where both have become one, on a higher level. So tiles of any
// two levels meet without a crack, in vertices that are the same to the last bit.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "../../io/scene.h"
#include "../../io/textured_model.h"

namespace gpvc::tileset {

/// The least depth of a quadtree with so many leaves; a root alone has depth 0.
int tree_depth(std::size_t leaves);

/// The least number of tiles that have at most so many faces; one at least.
std::size_t leaf_count(std::size_t faces, std::size_t faces_per_tile);

/// Per face, the number of its leaf, 0 to 4^tree_depth(leaves) - 1: the children of tile n are tiles 4 n to 4 n + 3 of the level below.
/// Tiles are divided across the longer of their two axes on the ground, by the order of the faces' middles along it, so that
/// all leaves have equally many faces. O(faces depth), TBB. \param up the axis that is not on the ground
std::vector<std::uint32_t> leaf_of_faces(const Mesh& mesh, io::UpAxis up, std::size_t leaves);

struct LevelMesh {
  Mesh mesh;
  std::vector<std::uint32_t> tile;  ///< per face, ascending
  /// Per tile, at most how far the surface is from that of level 0, as the simplifier's quadrics tell; units of the mesh.
  std::vector<double> error;
  std::vector<std::uint32_t> vertex{};  ///< per vertex, its number in the finer mesh
};

/// The level above one, with a quarter of its tiles. `error`: per tile of the finer level. O(faces log faces), TBB.
LevelMesh coarser_level(const Mesh& finer, std::span<const std::uint32_t> tile, std::span<const double> error);

}  // namespace gpvc::tileset
