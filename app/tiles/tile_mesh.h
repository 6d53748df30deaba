// A mesh in tiles: what each tile holds of it, and the mesh that some tiles make together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "app/checks/framing.h"
#include "io/grouping.h"
#include "io/scene.h"

namespace gpvc::tiles {

/// As far as the border of a tile reaches into its neighbours: as far as seam leveling carries an offset (see
/// atlas::AtlasInput::border), which is farther than a label grows in a move of the solver (labeling::kReselectEdges) and
/// than outliers are averaged.
inline constexpr int kBorderEdges = 48;

/// The faces of a tile and those around it, its border, in the order of the whole mesh. So whatever depends on the order of
/// faces is decided as in a run over all of them.
struct TileMesh {
  Mesh mesh;
  std::vector<std::uint64_t> face;    ///< per face, its number in the whole mesh, ascending
  std::vector<std::uint32_t> vertex;  ///< per vertex, its number in the whole mesh, ascending
  std::vector<std::uint32_t> tile;    ///< per face, the tile that it is a face of
  std::vector<std::uint32_t> place;   ///< per face, which of that tile's own faces it is

  /// Per face, 1 for the border of this tile.
  std::vector<std::uint8_t> border(std::uint32_t number) const;
  /// The faces of the tile itself, ascending.
  std::vector<std::uint32_t> own(std::uint32_t number) const;
};

/// Cuts a mesh into tiles, one after another. Borrows what it is given.
class TileCutter {
 public:
  /// \param tile per face
  TileCutter(const Mesh& mesh, std::span<const std::uint32_t> tile, std::size_t tiles);
  /// O(faces of the tile and its border x log).
  TileMesh cut(std::uint32_t tile);
  /// Tiles that share an edge with this one, ascending.
  std::vector<std::uint32_t> beside(std::uint32_t tile) const;

 private:
  const Mesh& mesh_;
  std::span<const std::uint32_t> tile_;
  Grouped<std::uint32_t> faces_;       ///< by tile
  Grouped<std::uint32_t> neighbours_;  ///< by face
  std::vector<std::uint32_t> place_;
  std::vector<std::uint8_t> taken_;  ///< per face; all 0 between calls
};

/// The place of a face or vertex that is not there.
inline constexpr std::uint32_t kNowhere = 0xFFFFFFFFu;

/// Tiles put together again, without what is in none of them and without Mesh::file_positions, of which only the mesh's
/// own tiles are written. Add tiles, then call finish() once.
class TileUnion {
 public:
  /// The faces of the tile itself.
  void add(const TileMesh& tile, std::uint32_t number);
  /// Sorts faces and vertices as in the whole mesh.
  void finish();

  const Mesh& mesh() const { return mesh_; }
  /// Per face and per vertex of mesh(), its number.
  const std::vector<std::uint64_t>& face_numbers() const { return numbers_; }
  const std::vector<std::uint32_t>& vertex_numbers() const { return vertex_numbers_; }
  /// Per face of a tile, where it is in mesh(); kNowhere for those of tiles that were not added.
  std::vector<std::uint32_t> places_of(std::span<const std::uint64_t> faces) const;

 private:
  struct Vertex {
    std::uint32_t number;
    WorldPoint at;
  };
  std::vector<std::pair<std::uint64_t, Triangle>> faces_;
  std::vector<Vertex> vertices_;
  std::vector<std::uint64_t> numbers_;
  std::vector<std::uint32_t> vertex_numbers_;
  Mesh mesh_;
};

/// A tile of the level above four tiles, without a border: their faces, simplified to a quarter. Faces are numbered by the
/// tile and within it.
struct CoarseTile {
  TileMesh tile;
  double error = 0;  ///< how far its surface is from theirs
};
/// The number of a face above level 0: its tile, and which of the tile's faces it is.
inline std::uint64_t face_number(std::uint32_t tile, std::size_t place) { return std::uint64_t{tile} << 32 | place; }
CoarseTile coarse_tile(const TileUnion& children, std::uint32_t number);

/// A tile made by coarse_tile() with the border that it has in a union of itself and the tiles around it.
TileMesh with_border(const TileUnion& around, std::uint32_t number);

}  // namespace gpvc::tiles
