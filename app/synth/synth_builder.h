// Builds a synthetic scene from planes, boxes and balls, tessellated at a given edge length.
#pragma once

#include <functional>
#include <optional>
#include <unordered_map>

#include "app/synth/synth_scene.h"
#include "io/vector.h"

namespace gpvc::synth {

/// The rigid motion from a part's own axes (x along the ridge, y across, z up) into the scene.
struct Placement {
  WorldPoint origin;
  double cos = 1, sin = 0;
  WorldPoint turn(const WorldPoint& p) const { return {cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z}; }
  WorldPoint operator()(const WorldPoint& p) const { return origin + turn(p); }
};

class SynthBuilder {
 public:
  /// Coordinates are rounded to multiples of 1 / `grid_per_m`, so that floats hold them exactly and equal edges weld. With
  /// `count_only` faces are counted and no scene is made.
  SynthBuilder(double edge_m, double grid_per_m, std::uint32_t seed, bool count_only = false)
      : edge_m_(edge_m), grid_per_m_(grid_per_m), seed_(seed), count_only_(count_only) {}

  SynthScene take() { return std::move(scene_); }
  std::size_t faces() const { return count_only_ ? counted_ : scene_.mesh.faces.size(); }
  std::uint32_t seed() const { return seed_; }
  std::uint32_t chance_seed(std::uint32_t a, std::uint32_t b) const { return synth_hash(seed_, a, b); }

  /// A parallelogram that faces the direction du x dv, with a surface of its own.
  std::uint32_t quad(Material material, const WorldPoint& p, const WorldPoint& du, const WorldPoint& dv,
                     bool windows = false);
  std::size_t surfaces() const { return scene_.surfaces.size(); }
  Surface& surface(std::uint32_t id) { return scene_.surfaces[id]; }
  /// A triangle, counter-clockwise seen from outside.
  void triangle(Material material, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c);
  /// A box with corners lo and hi in the placement's axes, without its lower side unless `bottom`.
  void box(Material material, const Placement& place, const WorldPoint& lo, const WorldPoint& hi, bool bottom);
  /// A ball of leaves with lumps: a subdivided icosahedron whose vertices are moved outwards at random.
  void ball(const WorldPoint& centre, double radius_m, std::uint32_t seed);
  void trunk(const WorldPoint& foot, double height_m, double radius_m);
  /// A height field seen from above: of the cells of the rectangle `lo` to `hi` of the map those that lie entirely
  /// between `from` and `to`. Two over the same rectangle follow each other facet by facet. No value if there are no such
  /// cells.
  std::optional<std::uint32_t> relief(Material material, const WorldPoint& lo, const WorldPoint& hi,
                                      const WorldPoint& from, const WorldPoint& to,
                                      const std::function<double(double x, double y)>& height);

 private:
  int pieces(double length_m) const { return std::max(1, static_cast<int>(std::ceil(length_m / edge_m_))); }
  std::uint32_t add_surface(Material material, const WorldPoint& p, const WorldPoint& du, const WorldPoint& dv);
  std::uint32_t vertex(const WorldPoint& p);
  void face(std::uint32_t surface, std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Two triangles a cell. Diagonals alternate, so that no direction is preferred; `odd` selects the first cell's diagonal.
  void cells(std::uint32_t surface, const std::vector<std::uint32_t>& grid, int nu, int nv, bool odd = false);

  /// n^2 triangles of the triangle whose vertex at(i, j) lies i steps towards the second corner, j towards the third.
  template <class VertexAt>
  void triangular_cells(std::uint32_t surface, int n, VertexAt at);

  struct Key {
    std::int64_t x, y, z;
    bool operator==(const Key&) const = default;
  };
  struct KeyHash {
    std::size_t operator()(const Key& k) const {
      return synth_hash(static_cast<std::uint32_t>(k.x), static_cast<std::uint32_t>(k.y),
                        static_cast<std::uint32_t>(k.z));
    }
  };

  double edge_m_, grid_per_m_;
  std::uint32_t seed_;
  bool count_only_;
  std::size_t counted_ = 0;
  SynthScene scene_;
  std::unordered_map<Key, std::uint32_t, KeyHash> vertices_;
};

/// Where to search for the edge length: between two lengths, until they differ by less than the factor `precision`.
struct EdgeSearch {
  double fine_m, coarse_m;
  double precision = 1;
};

/// The scene that `build` makes at the edge length that gives about `faces` faces: their number falls as edges grow, so
/// the search bisects over counts.
SynthScene build_scene(std::size_t faces, EdgeSearch search, double grid_per_m, std::uint32_t seed,
                       const std::function<void(SynthBuilder&)>& build);

}  // namespace gpvc::synth
