#include "io/meshes/gltf_quantize.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "io/box.h"
#include "io/vector.h"

namespace gpvc::io {
namespace {

constexpr double kMost = 65535;

/// The length that nine in ten edges exceed; infinite where there is none.
double short_edge(const TexturedModel& model, const GltfGeometry& geometry) {
  constexpr std::size_t kSample = 100000;
  const std::vector<WorldPoint>& positions = model.mesh->written_positions();
  const std::size_t step = std::max<std::size_t>(1, geometry.faces.size() / kSample);
  std::vector<double> lengths;
  for (std::size_t n = 0; n < geometry.faces.size(); n += step) {
    const Triangle& face = model.mesh->faces[index(geometry.faces[n])];
    for (std::size_t corner = 0; corner < 3; ++corner)
      if (const double l = length(positions[face[(corner + 1) % 3]] - positions[face[corner]]); l > 0)
        lengths.push_back(l);
  }
  if (lengths.empty()) return std::numeric_limits<double>::infinity();
  const auto tenth = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 10);
  std::ranges::nth_element(lengths, tenth);
  return *tenth;
}

/// The numbers of triangles, ordered by their corners; equal ones by their numbers.
std::vector<std::uint32_t> by_corners(std::span<const std::uint32_t> indices) {
  std::vector<std::uint32_t> numbers(indices.size() / 3);
  std::iota(numbers.begin(), numbers.end(), 0u);
  const auto key = [&](std::uint32_t n) {
    return std::array{indices[3 * n], indices[3 * n + 1], indices[3 * n + 2], n};
  };
  std::ranges::sort(numbers, {}, key);
  return numbers;
}

}  // namespace

std::array<std::uint16_t, 3> PositionGrid::place(const WorldPoint& p) const {
  const auto number = [this](double local) {
    return static_cast<std::uint16_t>(std::clamp(std::round(local / step), 0.0, kMost));
  };
  const WorldPoint local = p - origin;
  return {number(local.x), number(local.y), number(local.z)};
}

std::optional<PositionGrid> position_grid(const TexturedModel& model, const GltfGeometry& geometry,
                                          const WorldPoint& offset) {
  constexpr double kStepsOfEdge = 8, kLargest = 0x1p100, kLeastStep = 0x1p-60;
  Box box;
  for (const GltfVertex& v : geometry.vertices) box.add(model.mesh->written_positions()[v.position] - offset);
  const double extent = std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
  if (!(extent < kLargest)) return std::nullopt;
  // The origin may lie a step below the least coordinate.
  const double step = std::exp2(std::ceil(std::log2(std::max(extent / (kMost - 1), kLeastStep))));
  if (step * kStepsOfEdge > short_edge(model, geometry)) return std::nullopt;
  const auto below = [step](double coordinate) { return std::floor(coordinate / step) * step; };
  return PositionGrid{{below(box.low.x), below(box.low.y), below(box.low.z)}, step};
}

void order_triangles(GltfGeometry& geometry) {
  for (const GltfPrimitive& primitive : geometry.primitives) {
    const std::span indices = std::span(geometry.indices).subspan(primitive.first_index, primitive.index_count);
    const std::span vertices = std::span(geometry.vertices).subspan(primitive.first_vertex, primitive.vertex_count);
    const std::span faces = std::span(geometry.faces).subspan(primitive.first_index / 3, primitive.index_count / 3);
    std::vector<std::uint32_t> ordered(indices.size());
    meshopt_optimizeVertexCache(ordered.data(), indices.data(), indices.size(), vertices.size());
    const std::vector<std::uint32_t> before = by_corners(indices), after = by_corners(ordered);
    const std::vector<FaceId> faces_before(faces.begin(), faces.end());
    for (std::size_t n = 0; n < after.size(); ++n) faces[after[n]] = faces_before[before[n]];
    std::vector<std::uint32_t> number(vertices.size());
    meshopt_optimizeVertexFetchRemap(number.data(), ordered.data(), ordered.size(), vertices.size());
    const std::vector<GltfVertex> vertices_before(vertices.begin(), vertices.end());
    for (std::size_t v = 0; v < number.size(); ++v) vertices[number[v]] = vertices_before[v];
    std::ranges::transform(ordered, indices.begin(), [&](std::uint32_t v) { return number[v]; });
  }
}

}  // namespace gpvc::io
