// Vertices for formats that repeat them in every triangle, or wherever a texture has a seam.
#pragma once

#include <bit>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "io/scene.h"

namespace gpvc::io {

/// Makes one vertex of all corners with the same coordinates, as exporters write each vertex the same way in all its
/// triangles. Numbered in the order of their first use.
class MergedVertices {
 public:
  explicit MergedVertices(std::vector<WorldPoint>& positions) : positions_(positions) {}
  void reserve(std::size_t vertices) { numbers_.reserve(vertices); }
  std::uint32_t add(const WorldPoint& p) {
    const auto [known, fresh] = numbers_.try_emplace(p, static_cast<std::uint32_t>(positions_.size()));
    if (fresh) positions_.push_back(p);
    return known->second;
  }

 private:
  struct Hash {
    std::size_t operator()(const WorldPoint& p) const {
      std::uint64_t hash = 0;
      // Adding 0 makes -0 and 0 one, as == does. Knuth's multiplier spreads what differs in high bits alone.
      for (const double v : {p.x, p.y, p.z}) {
        hash = (hash ^ std::bit_cast<std::uint64_t>(v + 0.0)) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
      }
      return hash;
    }
  };
  std::vector<WorldPoint>& positions_;
  std::unordered_map<WorldPoint, std::uint32_t, Hash> numbers_;
};

}  // namespace gpvc::io
