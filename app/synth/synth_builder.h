// Builds a synthetic scene from planes, boxes and balls, tessellated at a given edge length.
#pragma once

#include <functional>
#include <optional>
#include <unordered_map>

#include "app/synth/synth_scene.h"
#include "io/world_vector.h"

namespace gpvc::synth {

/// Turns and moves what is built in axes of its own: x along the ridge, y across, z up.
struct Placement {
  WorldPoint origin;
  double cos = 1, sin = 0;
  WorldPoint turn(const WorldPoint& p) const { return {cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z}; }
  WorldPoint operator()(const WorldPoint& p) const { return origin + turn(p); }
};

class SynthBuilder {
 public:
  /// Coordinates are rounded to multiples of 1 / `grid` m, so that floats hold them and equal edges weld. With
  /// `count_only` no scene is made, only faces are counted.
  SynthBuilder(double edge_m, double grid, std::uint32_t seed, bool count_only = false)
      : edge_m_(edge_m), grid_(grid), seed_(seed), count_only_(count_only) {}

  SynthScene take() { return std::move(scene_); }
  std::size_t faces() const { return count_only_ ? counted_ : scene_.mesh.faces.size(); }
  std::uint32_t chance_seed(std::uint32_t a, std::uint32_t b) const { return synth_hash(seed_, a, b); }

  /// A parallelogram seen from du x dv, in its own surface.
  std::uint32_t quad(Material material, const WorldPoint& p, const WorldPoint& du, const WorldPoint& dv,
                     bool windows = false);
  std::size_t surfaces() const { return scene_.surfaces.size(); }
  Surface& surface(std::uint32_t id) { return scene_.surfaces[id]; }
  /// A triangle a, b, c, counter-clockwise from outside.
  void triangle(Material material, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c);
  /// A box with corners lo and hi in the placement's axes, without its lower side unless `bottom`.
  void box(Material material, const Placement& place, const WorldPoint& lo, const WorldPoint& hi, bool bottom);
  /// A lumpy ball of leaves: an icosahedron, split and pushed out by chance.
  void ball(const WorldPoint& centre, double radius_m, std::uint32_t seed);
  void trunk(const WorldPoint& foot, double height_m, double radius_m);
  /// Ground of the height that `height` gives, over a rectangle of the map, seen from above.
  std::uint32_t relief(Material material, const WorldPoint& lo, const WorldPoint& hi,
                       const std::function<double(double x, double y)>& height);
  /// The cells of relief(lo, hi) that lie between `from` and `to` entirely, in a surface of their own: what follows the
  /// same heights follows them facet by facet. Nothing where there are no such cells.
  std::optional<std::uint32_t> relief_part(Material material, const WorldPoint& lo, const WorldPoint& hi,
                                           const WorldPoint& from, const WorldPoint& to,
                                           const std::function<double(double x, double y)>& height);

 private:
  int pieces(double length_m) const { return std::max(1, static_cast<int>(std::ceil(length_m / edge_m_))); }
  std::uint32_t add_surface(Material material, const WorldPoint& p, const WorldPoint& du, const WorldPoint& dv);
  std::uint32_t vertex(const WorldPoint& p);
  void face(std::uint32_t surface, std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Two triangles a cell; diagonals alternate, so that no direction is preferred, and `odd` says with which of the two
  /// the first cell begins.
  void cells(std::uint32_t surface, const std::vector<std::uint32_t>& grid, int nu, int nv, bool odd = false);

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

  double edge_m_, grid_;
  std::uint32_t seed_;
  bool count_only_;
  std::size_t counted_ = 0;
  SynthScene scene_;
  std::unordered_map<Key, std::uint32_t, KeyHash> vertices_;
};

}  // namespace gpvc::synth
