#include "atlas/leveling/seam_samples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "atlas/baking/each_photo.h"

namespace gpvc::atlas {

namespace {

/// A sample each texel serves the strips along seams; a very long edge is sampled more sparsely.
constexpr int kMostSamples = 512;

bool has_view(const AtlasInput& input, std::uint32_t face) {
  return input.labels[face] != kNoView && input.tags[face] != labeling::FaceTag::unseen;
}

/// The two vertices that both faces have; false for faces that share none or are degenerate.
bool shared_edge(const Mesh& mesh, std::uint32_t a, std::uint32_t b, std::array<std::uint32_t, 2>& vertices) {
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t u = mesh.faces[a][e], v = mesh.faces[a][(e + 1) % 3];
    const auto& t = mesh.faces[b];
    if (u == v || std::find(t.begin(), t.end(), u) == t.end() || std::find(t.begin(), t.end(), v) == t.end()) continue;
    vertices = {u, v};
    return true;
  }
  return false;
}

std::optional<PixelPoint> project(const View& view, const WorldPoint& p) {
  const CameraPoint c = camera_from_world(view.pose, p);
  if (!(c.z > 0)) return std::nullopt;
  return pixel_from_camera(view.camera, c);
}

/// Squared gradient, central differences, of the channel where it is largest.
float steepness2(const Image& photo, const PhotoPoint& q) {
  const Color dx = 0.5f * (sample_bilinear(photo, q.x + 1, q.y) - sample_bilinear(photo, q.x - 1, q.y));
  const Color dy = 0.5f * (sample_bilinear(photo, q.x, q.y + 1) - sample_bilinear(photo, q.x, q.y - 1));
  return std::max({dx.r * dx.r + dy.r * dy.r, dx.g * dx.g + dy.g * dy.g, dx.b * dx.b + dy.b * dy.b});
}

class Sampler {
 public:
  Sampler(const AtlasInput& input, const CoverageIndex& coverage) : input_(input), coverage_(coverage) {}

  SeamSamples sample() {
    find_edges();
    const std::size_t count = result_.colors.size();
    for (auto& side : steepness2_) side.assign(count, kNotShown);
    std::vector<std::vector<std::pair<std::uint32_t, int>>> sides(input_.scene.views.size());
    for (std::uint32_t e = 0; e < result_.edges.size(); ++e)
      for (int side = 0; side < 2; ++side)
        sides[index(input_.labels[result_.edges[e].faces[static_cast<std::size_t>(side)]])].emplace_back(e, side);
    std::vector<std::uint32_t> views;
    for (std::uint32_t v = 0; v < sides.size(); ++v)
      if (!sides[v].empty()) views.push_back(v);
    each_photo(input_.photos, views, [&](std::uint32_t v, const Image& photo) {
      tbb::parallel_for(std::size_t{0}, sides[v].size(), [&](std::size_t i) {
        sample_side(sides[v][i].first, static_cast<std::size_t>(sides[v][i].second), ViewId{v}, photo);
      });
    });
    result_.weight.assign(count, 0.0f);
    for (std::size_t i = 0; i < count; ++i) {
      if (steepness2_[0][i] == kNotShown || steepness2_[1][i] == kNotShown) continue;
      const float noise2 = kPhotoNoise * kPhotoNoise;
      const float shift2 = kMisregistration_px * kMisregistration_px;
      result_.weight[i] = noise2 / (noise2 + shift2 * (steepness2_[0][i] + steepness2_[1][i]));
    }
    return std::move(result_);
  }

 private:
  void find_edges() {
    std::size_t count = 0;
    for (const auto& [a, b] : input_.graph.edges) {
      if (input_.labels[a] == input_.labels[b] || !has_view(input_, a) || !has_view(input_, b)) continue;
      SeamEdge edge{{a, b}, {}, count, 0};
      if (!shared_edge(input_.mesh, a, b, edge.vertices)) continue;
      edge.samples = static_cast<std::uint32_t>(sample_count(edge));
      count += edge.samples;
      result_.edges.push_back(edge);
    }
    result_.colors.resize(count);
    result_.frame.resize(count);
  }

  int sample_count(const SeamEdge& edge) const {
    double longest = 0;
    for (const auto face : edge.faces) {
      const View& view = input_.scene.views[index(input_.labels[face])];
      const auto p = project(view, input_.mesh.positions[edge.vertices[0]]);
      const auto q = project(view, input_.mesh.positions[edge.vertices[1]]);
      if (p && q) longest = std::max(longest, std::hypot(p->x - q->x, p->y - q->y));
    }
    return static_cast<int>(std::clamp(std::ceil(longest), 1.0, double{kMostSamples}));
  }

  void sample_side(std::uint32_t e, std::size_t side, ViewId id, const Image& photo) {
    const SeamEdge& edge = result_.edges[e];
    const View& view = input_.scene.views[index(id)];
    const FaceId face{edge.faces[side]};
    const bool partial = input_.tags[index(face)] == labeling::FaceTag::partial;
    const visibility::FaceCoverage* seen = partial ? coverage_.find(face, id) : nullptr;
    if (partial && !seen) return;
    const WorldPoint &a = input_.mesh.positions[edge.vertices[0]], &b = input_.mesh.positions[edge.vertices[1]];
    for (std::uint32_t i = 0; i < edge.samples; ++i) {
      const double t = (i + 0.5) / edge.samples;
      const auto p = project(view, {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)});
      if (!p) continue;
      if (seen && !shows(*seen, *p)) continue;
      const auto q = photo_from_pixel(view.camera, *p);
      if (!q || q->x < 0 || q->y < 0 || q->x > photo.width || q->y > photo.height) continue;
      const std::size_t at = edge.first_sample + i;
      result_.colors[at][side] = sample_bilinear(photo, q->x, q->y);
      result_.frame[at][side] = *p;
      steepness2_[side][at] = steepness2(photo, *q);
    }
  }

  bool shows(const visibility::FaceCoverage& seen, const PixelPoint& p) const {
    if (!(p.x >= seen.x0 && p.y >= seen.y0 && p.x < seen.x0 + seen.width && p.y < seen.y0 + seen.height)) return false;
    return coverage_.table().sees(seen, static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)));
  }

  const AtlasInput& input_;
  const CoverageIndex& coverage_;
  SeamSamples result_;
  static constexpr float kNotShown = -1;
  std::array<std::vector<float>, 2> steepness2_;  ///< squared gradient, grey levels a pixel
};

}  // namespace

SeamSamples sample_seams(const AtlasInput& input, const CoverageIndex& coverage) {
  return Sampler(input, coverage).sample();
}

}  // namespace gpvc::atlas
