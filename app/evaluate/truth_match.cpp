// Which face of a textured model is which face of the synthetic mesh.
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "app/evaluate/truth.h"
#include "app/synth/synth_scene.h"
#include "io/box.h"
#include "io/vector.h"

namespace gpvc::evaluate {
namespace {

double distance(const WorldPoint& a, const WorldPoint& b) {
  return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

// Rounding to six printed digits, or to floats, of the model's own numbers; never more than a 4096th of the mesh's
// extent.
double tolerance_of(const Mesh& mesh, const Mesh& model) {
  double largest = 0;
  for (const WorldPoint& p : model.positions)
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  const auto [low, high] = box_of(mesh);
  const double extent = mesh.positions.empty() ? 0 : distance(low, high);
  return std::max(std::min(largest * 1e-5, extent / 4096), extent * 1e-12);
}

// The mesh's positions in cells of twice the tolerance; equal positions count as the first of them.
class Corners {
 public:
  Corners(const Mesh& mesh, double tolerance) : mesh_(mesh), tolerance_(tolerance) {
    first_.resize(mesh.positions.size());
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      std::vector<std::uint32_t>& cell = cells_[key(cell_of(mesh.positions[v]))];
      const auto same = std::find_if(cell.begin(), cell.end(),
                                     [&](std::uint32_t other) { return mesh.positions[other] == mesh.positions[v]; });
      first_[v] = same == cell.end() ? v : *same;
      if (same == cell.end()) cell.push_back(v);
    }
  }
  std::uint32_t first(std::uint32_t vertex) const { return first_[vertex]; }
  // The nearest position within the tolerance; kNoModelFace where there is none.
  std::uint32_t nearest(const WorldPoint& p) const {
    std::uint32_t best = kNoModelFace;
    double best_distance = tolerance_;
    const WorldPoint reach{tolerance_, tolerance_, tolerance_};
    const Cell low = cell_of(p - reach), high = cell_of(p + reach);
    for (std::int64_t z = low[2]; z <= high[2]; ++z)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
          const auto cell = cells_.find(key({x, y, z}));
          if (cell == cells_.end()) continue;
          for (const std::uint32_t v : cell->second) {
            const double d = distance(p, mesh_.positions[v]);
            if (d < best_distance || (d == best_distance && v < best)) {
              best_distance = d;
              best = v;
            }
          }
        }
    return best;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cell_of(const WorldPoint& p) const {
    const auto number = [&](double v) { return static_cast<std::int64_t>(std::floor(v / (2 * tolerance_))); };
    return {number(p.x), number(p.y), number(p.z)};
  }
  // Cells whose keys collide share a list; distances tell their positions apart.
  static std::uint64_t key(const Cell& c) {
    const auto bits = [](std::int64_t v) { return static_cast<std::uint32_t>(v); };
    return std::uint64_t{synth::synth_hash(bits(c[0]), bits(c[1]), bits(c[2]))} << 32 |
           synth::synth_hash(bits(c[2]), bits(c[0]), bits(c[1]));
  }
  const Mesh& mesh_;
  double tolerance_;
  std::vector<std::uint32_t> first_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

bool same_faces(const Mesh& mesh, const Mesh& model, const WorldPoint& offset, double tolerance) {
  if (mesh.faces != model.faces || mesh.positions.size() != model.positions.size()) return false;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (distance(mesh.positions[v], model.positions[v] + offset) > tolerance) return false;
  return true;
}

struct TripleHash {
  std::size_t operator()(const Triangle& t) const { return synth::synth_hash(t[0], t[1], t[2]); }
};

// Corners in ascending order, and where each of them stood.
struct Ordered {
  Triangle corners{};
  std::array<std::uint8_t, 3> place{0, 1, 2};
};

Ordered ordered(const Triangle& t) {
  Ordered o;
  std::sort(o.place.begin(), o.place.end(),
            [&](std::uint8_t a, std::uint8_t b) { return t[a] != t[b] ? t[a] < t[b] : a < b; });
  for (std::size_t i = 0; i < 3; ++i) o.corners[i] = t[o.place[i]];
  return o;
}

}  // namespace

MatchedModel match_model(const Mesh& mesh, const io::TexturedModel& model, std::span<const Image> pages,
                         const WorldPoint& offset) {
  MatchedModel matched;
  matched.model = &model;
  matched.pages = pages;
  const Mesh& other = *model.mesh;
  matched.model_face.assign(mesh.faces.size(), kNoModelFace);
  matched.corners.assign(mesh.faces.size(), {0, 1, 2});
  const double tolerance = tolerance_of(mesh, other);
  if (same_faces(mesh, other, offset, tolerance)) {
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) matched.model_face[f] = f;
    return matched;
  }
  const Corners corners(mesh, tolerance);
  std::unordered_map<Triangle, std::vector<std::uint32_t>, TripleHash> faces;  // of the mesh, by corners
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const Triangle& t = mesh.faces[f];
    faces[ordered({corners.first(t[0]), corners.first(t[1]), corners.first(t[2])}).corners].push_back(f);
  }
  std::vector<std::uint32_t> nearest;
  nearest.reserve(other.positions.size());
  for (const WorldPoint& p : other.positions) nearest.push_back(corners.nearest(p + offset));
  for (std::uint32_t g = 0; g < other.faces.size(); ++g) {
    const Triangle& t = other.faces[g];
    const Ordered theirs = ordered({nearest[t[0]], nearest[t[1]], nearest[t[2]]});
    const auto found = theirs.corners[2] == kNoModelFace ? faces.end() : faces.find(theirs.corners);
    if (found == faces.end()) {
      ++matched.unmatched_faces;
      continue;
    }
    for (const std::uint32_t f : found->second) {
      const bool has_texture =
          matched.model_face[f] != kNoModelFace && model.face_page[matched.model_face[f]] != io::kNoPage;
      if (has_texture) continue;
      matched.model_face[f] = g;
      const Triangle& mine = mesh.faces[f];
      const Ordered ours = ordered({corners.first(mine[0]), corners.first(mine[1]), corners.first(mine[2])});
      for (std::size_t i = 0; i < 3; ++i) matched.corners[f][ours.place[i]] = theirs.place[i];
    }
  }
  return matched;
}

}  // namespace gpvc::evaluate
