#include "atlas/alignment/surface_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "atlas/charts/chart_raster.h"
#include "io/photos.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

constexpr double kHalf = (kPatchEdge - 1) / 2.0 * io::kCoarsePixel;
/// A grid has points for a seventh of them.
constexpr std::size_t kMostFaces = 4096;

/// Columns or rows of a grid whose positions lie between two, on one axis: none unless first < end.
struct Range {
  std::size_t first = 0, end = 0;
};
Range between(double low, double high, double at) {
  const auto place = [&](double position) { return (position - (at - kHalf)) / io::kCoarsePixel; };
  const double first = std::clamp(place(low), 0.0, double{kPatchEdge});
  const double last = std::clamp(place(high), -1.0, kPatchEdge - 1.0);
  // Rounded up and down without std::ceil() and std::floor(), which are calls on the baseline processor.
  const auto whole = static_cast<std::size_t>(first);
  return {whole + (static_cast<double>(whole) < first ? 1 : 0), last < 0 ? 0 : static_cast<std::size_t>(last) + 1};
}

/// Faces, each once, in the order in which they were first added.
class FaceList {
 public:
  std::size_t size() const { return faces_.size(); }
  std::uint32_t operator[](std::size_t i) const { return faces_[i]; }
  /// False if it was added before.
  bool add(std::uint32_t face) {
    std::uint32_t& slot = slot_of(face);
    if (slot == face) return false;
    slot = face;
    faces_.push_back(face);
    if (2 * faces_.size() > slots_.size()) grow();
    return true;
  }

 private:
  /// The face's, or the free one that it is to have.
  std::uint32_t& slot_of(std::uint32_t face) {
    const std::size_t last = slots_.size() - 1;
    // Of numbers that follow each other the upper bits of this product differ most (Knuth, The Art of Computer Programming 3, 6.4).
    std::size_t at = (face * 0x9E3779B1u) >> (32 - std::countr_zero(slots_.size()));
    while (slots_[at] != face && slots_[at] != kNoOwner) at = (at + 1) & last;
    return slots_[at];
  }
  void grow() {
    slots_.assign(2 * slots_.size(), kNoOwner);
    for (const std::uint32_t face : faces_) slot_of(face) = face;
  }

  std::vector<std::uint32_t> faces_;
  std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(1024, kNoOwner);  ///< a power of two
};

struct Plane {
  WorldPoint normal;
  double distance = 0;  ///< of the view's centre, times the normal's length

  /// How many times the ray leads to the plane; nullopt beside or behind the camera.
  std::optional<double> depth_along(const WorldPoint& ray) const {
    const double depth = distance / dot(normal, ray);
    return depth > 0 && std::isfinite(depth) ? std::optional(depth) : std::nullopt;
  }
};

Plane plane_of(const Mesh& mesh, const View& view, std::uint32_t face) {
  const Triangle& t = mesh.faces[face];
  const WorldPoint& p = mesh.positions[t[0]];
  const WorldPoint normal = cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p);
  return {normal, dot(normal, p - view.pose.centre)};
}

using FrameTriangle = std::array<PixelPoint, 3>;

std::optional<FrameTriangle> frame_triangle(const Mesh& mesh, const View& view, std::uint32_t face) {
  FrameTriangle corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = pixel_from_world(view, mesh.positions[mesh.faces[face][i]]);
    if (!at) return std::nullopt;
    corners[i] = *at;
  }
  return corners;
}

/// Twice the area of a triangle, by the way it turns.
double turn(const PixelPoint& a, const PixelPoint& b, const PixelPoint& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

bool contains(const FrameTriangle& corners, const PixelPoint& p) {
  const auto& [a, b, c] = corners;
  const double s = turn(a, b, p), t = turn(b, c, p), u = turn(c, a, p);
  // Without branches: which of them a point takes is not foreseen.
  const int right = int{s >= 0} & int{t >= 0} & int{u >= 0}, left = int{s <= 0} & int{t <= 0} & int{u <= 0};
  return (right | left) != 0;
}

/// Faces around a place lie all over the memory of a mesh: they are fetched while those before are in use.
void prefetch_face(const Mesh& mesh, const FaceNeighbours& neighbours, std::uint32_t face) {
  __builtin_prefetch(&mesh.faces[face]);
  __builtin_prefetch(&neighbours.first[face]);
}
/// To be called later than the above.
void prefetch_corners(const Mesh& mesh, const FaceNeighbours& neighbours, std::uint32_t face) {
  for (const std::uint32_t vertex : mesh.faces[face]) __builtin_prefetch(&mesh.positions[vertex]);
  __builtin_prefetch(neighbours.items.data() + neighbours.first[face]);
}

/// Rays of a view's frame: that of (x, y) is base + x along_x + y along_y.
struct Rays {
  explicit Rays(const View& view)
      : base(ray_of(view, {0, 0})), along_x(ray_of(view, {1, 0}) - base), along_y(ray_of(view, {0, 1}) - base) {}
  WorldPoint operator()(const PixelPoint& p) const { return base + p.x * along_x + p.y * along_y; }
  WorldPoint base, along_x, along_y;
};

}  // namespace

PixelPoint grid_position(const SurfacePlace& place, std::size_t column, std::size_t row) {
  return {place.at.x - kHalf + static_cast<double>(column) * io::kCoarsePixel,
          place.at.y - kHalf + static_cast<double>(row) * io::kCoarsePixel};
}

std::optional<SurfaceGrid> surface_around(const Mesh& mesh, const FaceNeighbours& neighbours, const Scene& scene,
                                          const SurfacePlace& place) {
  const View& view = scene.views[index(place.reference)];
  const Rays rays(view);
  SurfaceGrid grid;
  grid.faces.fill(kNoOwner);
  grid.depth.fill(std::numeric_limits<float>::infinity());
  if (!frame_triangle(mesh, view, place.face)) return std::nullopt;
  FaceList around;
  around.add(place.face);
  for (std::size_t i = 0; i < around.size(); ++i) {
    constexpr std::size_t kAhead = 4;
    if (i + kAhead < around.size()) prefetch_corners(mesh, neighbours, around[i + kAhead]);
    const auto corners = frame_triangle(mesh, view, around[i]);
    if (!corners) continue;
    const auto& [a, b, c] = *corners;
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
    if (right < place.at.x - kHalf || left > place.at.x + kHalf || bottom < place.at.y - kHalf ||
        top > place.at.y + kHalf)
      continue;
    const Range rows = between(top, bottom, place.at.y), columns = between(left, right, place.at.x);
    const Plane plane = plane_of(mesh, view, around[i]);
    for (std::size_t row = rows.first; row < rows.end; ++row) {
      for (std::size_t column = columns.first; column < columns.end; ++column) {
        const PixelPoint p = grid_position(place, column, row);
        if (!contains(*corners, p)) continue;
        const auto depth = plane.depth_along(rays(p));
        const std::size_t at = row * kPatchEdge + column;
        if (!depth || *depth >= double{grid.depth[at]}) continue;
        grid.depth[at] = static_cast<float>(*depth);
        grid.faces[at] = around[i];
      }
    }
    if (around.size() > kMostFaces) return std::nullopt;
    for (const std::uint32_t next : neighbours[around[i]])
      if (around.add(next)) prefetch_face(mesh, neighbours, next);
  }
  const Plane own = plane_of(mesh, view, place.face);
  for (std::size_t row = 0; row < kPatchEdge; ++row) {
    for (std::size_t column = 0; column < kPatchEdge; ++column) {
      float& depth = grid.depth[row * kPatchEdge + column];
      if (std::isfinite(depth)) continue;
      const auto found = own.depth_along(rays(grid_position(place, column, row)));
      if (!found) return std::nullopt;
      depth = static_cast<float>(*found);
    }
  }
  return grid;
}

std::optional<WorldPoint> point_on_face(const Mesh& mesh, const Scene& scene, const SurfacePlace& place) {
  const View& view = scene.views[index(place.reference)];
  const WorldPoint ray = ray_of(view, place.at);
  const auto depth = plane_of(mesh, view, place.face).depth_along(ray);
  if (!depth) return std::nullopt;
  return view.pose.centre + *depth * ray;
}

std::optional<std::array<double, 4>> other_from_reference(const Mesh& mesh, const Scene& scene,
                                                          const SurfacePlace& place, ViewId other) {
  const auto in_other = [&](double x, double y) -> std::optional<PixelPoint> {
    const auto point = point_on_face(mesh, scene, {place.reference, {x, y}, place.face});
    return point ? pixel_from_world(scene.views[index(other)], *point) : std::nullopt;
  };
  const auto& [x, y] = place.at;
  const auto left = in_other(x - 1, y), right = in_other(x + 1, y), above = in_other(x, y - 1),
             below = in_other(x, y + 1);
  if (!left || !right || !above || !below) return std::nullopt;
  return std::array{(right->x - left->x) / 2, (below->x - above->x) / 2, (right->y - left->y) / 2,
                    (below->y - above->y) / 2};
}

}  // namespace gpvc::atlas
