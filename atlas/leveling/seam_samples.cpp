#include "atlas/leveling/seam_samples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "atlas/baking/each_photo.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// Strips need about a sample per texel along a seam; longer edges are sampled more sparsely.
constexpr int kMostSamples = 512;

/// The vertices of an edge that both faces have; nullopt for faces that share none or are degenerate.
std::optional<std::array<std::uint32_t, 2>> shared_edge(const Triangle& a, const Triangle& b) {
  const auto in_b = [&](std::uint32_t v) { return std::find(b.begin(), b.end(), v) != b.end(); };
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t u = a[e], v = a[(e + 1) % 3];
    if (u != v && in_b(u) && in_b(v)) return std::array{u, v};
  }
  return std::nullopt;
}

std::optional<PixelPoint> project(const View& view, const WorldPoint& p) {
  const CameraPoint c = camera_from_world(view.pose, p);
  if (!(c.z > 0)) return std::nullopt;
  return pixel_from_camera(view.camera, c);
}

/// Squared gradient of the channel where it is largest, by central differences.
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
    for (auto& side : steepness2_) side.assign(result_.colors.size(), kNotShown);
    using Sides = std::vector<std::pair<const SeamEdge*, std::size_t>>;
    std::vector<Sides> sides_of_view(input_.scene.views.size());
    for (const SeamEdge& edge : result_.edges)
      for (std::size_t side = 0; side < 2; ++side)
        sides_of_view[index(input_.labels[edge.faces[side]])].emplace_back(&edge, side);
    each_photo(input_, sides_of_view, PhotoOrder::descending, [&](const ViewPhoto& photo, const Sides& sides) {
      tbb::parallel_for(std::size_t{0}, sides.size(),
                        [&](std::size_t i) { sample_side(*sides[i].first, sides[i].second, photo); });
    });
    weigh();
    return std::move(result_);
  }

 private:
  void find_edges() {
    std::size_t count = 0;
    for (const auto& [a, b] : input_.graph.edges) {
      if (input_.labels[a] == input_.labels[b] || !has_view(input_, a) || !has_view(input_, b)) continue;
      const auto vertices = shared_edge(input_.mesh.faces[a], input_.mesh.faces[b]);
      if (!vertices) continue;
      SeamEdge edge{{a, b}, *vertices, count, 0};
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

  void sample_side(const SeamEdge& edge, std::size_t side, const ViewPhoto& photo) {
    const FaceId face{edge.faces[side]};
    const bool partial = input_.tags[index(face)] == labeling::FaceTag::partial;
    const visibility::FaceCoverage* seen = partial ? coverage_.find(face, photo.id) : nullptr;
    if (partial && !seen) return;
    const WorldPoint &a = input_.mesh.positions[edge.vertices[0]], &b = input_.mesh.positions[edge.vertices[1]];
    for (std::uint32_t i = 0; i < edge.samples; ++i) {
      const auto p = project(photo.view, a + (i + 0.5) / edge.samples * (b - a));
      if (!p) continue;
      if (seen && !shows(*seen, *p)) continue;
      const auto q = photo_from_pixel(photo.view.camera, *p);
      if (!q || q->x < 0 || q->y < 0 || q->x > photo.image.width || q->y > photo.image.height) continue;
      const std::size_t at = edge.first_sample + i;
      result_.colors[at][side] = sample_bilinear(photo.image, q->x, q->y);
      result_.frame[at][side] = *p;
      steepness2_[side][at] = steepness2(photo.image, *q);
    }
  }

  void weigh() {
    constexpr float kNoise2 = kPhotoNoise * kPhotoNoise, kShift2 = kMisregistrationPx * kMisregistrationPx;
    result_.weight.assign(result_.colors.size(), 0.0f);
    for (std::size_t i = 0; i < result_.weight.size(); ++i)
      if (steepness2_[0][i] != kNotShown && steepness2_[1][i] != kNotShown)
        result_.weight[i] = kNoise2 / (kNoise2 + kShift2 * (steepness2_[0][i] + steepness2_[1][i]));
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
