#include "app/tileset/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include "io/vector.h"

namespace gpvc::tileset {
namespace {

constexpr std::size_t kQuarter = 4;

double area_of(const Mesh& mesh, std::span<const Triangle> faces) {
  double area = 0;
  for (const Triangle& t : faces) {
    const WorldPoint& a = mesh.positions[t[0]];
    area += length(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a)) / 2;
  }
  return area;
}

// Gentle waves that the simplifier is shown on every surface. What is flat would become long slivers and faces across whole
// streets otherwise, as they are no worse than small ones: nearly every photo shows such a face in parts alone, one photo has to
// do for all of it, and perspective bends it.
class Waves {
 public:
  // \param edge the mean edge of the simplified faces
  explicit Waves(double edge)
      : frequency_(edge > 0 ? 2 * std::numbers::pi / (kLength * edge) : 0), height_(kHeight * edge) {}
  // `p`: not far from the origin.
  WorldPoint operator()(const WorldPoint& p) const {
    return p + height_ * WorldPoint{at(p.y, p.z), at(p.z, p.x), at(p.x, p.y)};
  }

 private:
  // Two frequencies, so that no direction is straight everywhere.
  double at(double a, double b) const {
    constexpr double kSecond = 1.3;
    return std::sin(frequency_ * a) + std::sin(kSecond * frequency_ * b);
  }

  // Of mean edges. A face over a quarter of a wave, eight edges, is off by a third of the height, a fifth of an edge; one of a
  // few edges by less than what the simplifier takes away elsewhere. On a city of 324 thousand faces the next two levels then
  // need a third of the memory for what photos show in parts, and their scores on photos held out stay within 0.004.
  static constexpr double kLength = 32, kHeight = 0.64;
  double frequency_, height_;
};

// Of the corners of some faces, those at one position have the same vertex, the first of these.
std::vector<Triangle> welded(const Mesh& mesh, std::span<const std::uint32_t> faces) {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t face : faces)
    vertices.insert(vertices.end(), mesh.faces[face].begin(), mesh.faces[face].end());
  const auto place = [&](std::uint32_t v) {
    const WorldPoint& p = mesh.positions[v];
    return std::tuple(p.x, p.y, p.z);
  };
  std::ranges::sort(vertices, {}, [&](std::uint32_t v) { return std::tuple(place(v), v); });
  std::vector<Triangle> result;
  for (const std::uint32_t face : faces) {
    Triangle& t = result.emplace_back(mesh.faces[face]);
    for (std::uint32_t& v : t) v = *std::ranges::lower_bound(vertices, place(v), {}, place);
  }
  return result;
}

// Faces by whether they are there turned over as well.
struct Sides {
  std::vector<Triangle> single;
  std::vector<Triangle> doubled;  // one of both sides
};

Sides sides_of(const std::vector<Triangle>& faces) {
  // The corners from the least on, ascending, and whether that turns the face over.
  const auto key = [&](std::uint32_t f) {
    Triangle t = faces[f];
    std::rotate(t.begin(), std::ranges::min_element(t), t.end());
    const bool turned = t[1] > t[2];
    if (turned) std::swap(t[1], t[2]);
    return std::tuple(t, turned, f);
  };
  std::vector<std::uint32_t> order(faces.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, {}, key);
  enum class Fate : std::uint8_t { left_out, single, doubled };
  std::vector<Fate> fate(faces.size(), Fate::left_out);
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const Triangle corners = std::get<0>(key(order[begin]));
    while (end < order.size() && std::get<0>(key(order[end])) == corners) ++end;
    if (corners[0] == corners[1] || corners[1] == corners[2]) continue;  // two corners at one position
    const bool both = std::get<1>(key(order[begin])) != std::get<1>(key(order[end - 1]));
    // The first in the file's order: where sides follow each other, or all fronts come before all backs, those of a surface
    // are turned alike.
    const std::uint32_t first = *std::min_element(order.begin() + static_cast<std::ptrdiff_t>(begin),
                                                  order.begin() + static_cast<std::ptrdiff_t>(end));
    fate[first] = both ? Fate::doubled : Fate::single;
  }
  Sides sides;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (fate[f] == Fate::single) sides.single.push_back(faces[f]);
    if (fate[f] == Fate::doubled) sides.doubled.push_back(faces[f]);
  }
  return sides;
}

Simplified simplify(const Mesh& mesh, const std::vector<Triangle>& faces) {
  std::vector<std::uint32_t> vertices;
  for (const Triangle& face : faces) vertices.insert(vertices.end(), face.begin(), face.end());
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  if (vertices.empty()) return {};
  // Relative to a vertex, so that floats hold them; the simplifier returns vertices, not positions.
  const WorldPoint& origin = mesh.positions[vertices[0]];
  const Waves wavy(std::sqrt(2 * kQuarter * area_of(mesh, faces) / static_cast<double>(faces.size())));
  std::vector<float> positions;
  for (const std::uint32_t v : vertices) {
    const WorldPoint p = wavy(mesh.positions[v] - origin);
    for (const double distance : {p.x, p.y, p.z}) positions.push_back(static_cast<float>(distance));
  }
  std::vector<unsigned int> indices, kept(3 * faces.size());
  for (const Triangle& face : faces)
    for (const std::uint32_t v : face)
      indices.push_back(static_cast<unsigned int>(std::ranges::lower_bound(vertices, v) - vertices.begin()));
  constexpr float kAnyError = 1;  // of the extent
  constexpr std::size_t kStride = 3 * sizeof(float);
  const std::size_t target = 3 * std::max<std::size_t>(1, faces.size() / kQuarter);
  float error = 0;
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), positions.data(), vertices.size(), kStride,
                               target, kAnyError, meshopt_SimplifyLockBorder, &error));
  Simplified result;
  for (std::size_t i = 0; i < kept.size(); i += 3)
    result.faces.push_back({vertices[kept[i]], vertices[kept[i + 1]], vertices[kept[i + 2]]});
  result.error = double{error} * double{meshopt_simplifyScale(positions.data(), vertices.size(), kStride)};
  return result;
}

}  // namespace

Simplified simplified(const Mesh& mesh, std::span<const std::uint32_t> faces) {
  const Sides sides = sides_of(welded(mesh, faces));
  Simplified result = simplify(mesh, sides.single);
  // Apart from the others: an edge that both sides share has four faces, and is no border to the simplifier.
  const Simplified front = simplify(mesh, sides.doubled);
  for (const Triangle& t : front.faces) {
    result.faces.push_back(t);
    result.faces.push_back({t[0], t[2], t[1]});
  }
  result.error = std::max(result.error, front.error);
  return result;
}

}  // namespace gpvc::tileset
