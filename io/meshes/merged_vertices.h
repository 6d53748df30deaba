// Vertices for formats that repeat them in every triangle, or wherever a texture has a seam.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "io/vector.h"

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
    std::size_t operator()(const WorldPoint& p) const { return position_hash(p); }
  };
  std::vector<WorldPoint>& positions_;
  std::unordered_map<WorldPoint, std::uint32_t, Hash> numbers_;
};

}  // namespace gpvc::io
