#include "atlas/leveling/seam_samples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "atlas/alignment/place_patches.h"
#include "atlas/blending/coarse_photo.h"
#include "atlas/leveling/finished_texture.h"
#include "atlas/leveling/overlap_ratios.h"
#include "atlas/leveling/seam_blend.h"
#include "atlas/sampling/each_photo.h"
#include "io/provided_memory.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// Strips need about a sample per texel along a seam; longer edges are sampled more sparsely.
constexpr int kMostSamples = 512;

/// The mean squared change of colour, in the channel where it is largest, if the place moves at random: in x and in y by
/// normal distributions of deviation kMisregistrationPx. A gradient would not do: an edge two pixels away has none here.
///
/// The distance moved has a Rayleigh distribution. Its range is cut at 0.5, 1.5 and 2.5 deviations; each part but the first,
/// where little changes, is represented by four places at 1, 2 and 3 deviations, those of the second in the diagonals.
/// \param shown the colour at a place
template <typename Shown>
float expected_change2(const Shown& shown, const PhotoPoint& q) {
  struct Ring {
    double x, y;  ///< one of its places; the others are turned by 90 degrees
    float share;  ///< exp(-a^2 / 2) - exp(-b^2 / 2) for distances from a to b deviations
  };
  constexpr double kDeviation = kMisregistrationPx, kSqrt2 = 1.41421356237;
  constexpr std::array kRings{Ring{kDeviation, 0, 0.558f}, Ring{kSqrt2 * kDeviation, kSqrt2 * kDeviation, 0.281f},
                              Ring{3 * kDeviation, 0, 0.044f}};
  const Color here = shown(q);
  Color mean;
  for (const auto& [x, y, share] : kRings)
    for (const auto& [dx, dy] : {std::pair(x, y), std::pair(-y, x), std::pair(-x, -y), std::pair(y, -x)}) {
      const Color d = shown({q.x + dx, q.y + dy}) - here;
      mean = mean + (share / 4) * Color{d.r * d.r, d.g * d.g, d.b * d.b};
    }
  return std::max({mean.r, mean.g, mean.b});
}

/// About one a pixel of the view that shows the edge larger.
int sample_count(const AtlasInput& input, const SeamEdge& edge) {
  double longest = 0;
  for (const auto face : edge.faces) {
    const View& view = input.scene.views[index(input.labels[face])];
    const auto p = pixel_from_world(view, input.mesh.positions[edge.vertices[0]]);
    const auto q = pixel_from_world(view, input.mesh.positions[edge.vertices[1]]);
    if (p && q) longest = std::max(longest, std::hypot(p->x - q->x, p->y - q->y));
  }
  return static_cast<int>(std::clamp(std::ceil(longest), 1.0, double{kMostSamples}));
}

class Sampler {
 public:
  Sampler(const AtlasInput& input, const CoverageIndex& coverage) : input_(input), coverage_(coverage) {}

  SeamSamples sample(std::vector<SeamEdge> edges, const AlsoSampled& others) {
    result_.edges = std::move(edges);
    const std::size_t count =
        result_.edges.empty() ? 0 : result_.edges.back().first_sample + result_.edges.back().samples;
    result_.colors = filled(count, std::array<Color, 2>{});
    result_.frame = filled(count, std::array<PixelPoint, 2>{});
    for (auto& side : change2_) side = filled(count, kNotShown);
    std::vector<Work> work(input_.scene.views.size());
    for (const SeamEdge& edge : result_.edges)
      for (std::size_t side = 0; side < 2; ++side)
        if (!is_finished(input_, edge.faces[side]))
          work[index(input_.labels[edge.faces[side]])].sides.emplace_back(&edge, side);
    for (std::uint32_t view = 0; view < work.size(); ++view) {
      work[view].blends = others.blend != nullptr && others.blend->needs(ViewId{view});
      work[view].cuts = others.cuts != nullptr && others.cuts->needs(ViewId{view});
      work[view].overlaps = others.overlaps != nullptr && others.overlaps->needs(ViewId{view});
    }
    const auto fetch = [this](ViewId id) { return input_.photos.coarse(id); };
    each_fetched(
        work, PhotoOrder::ascending, fetch, [&](ViewId id, std::shared_ptr<const Image>& means, const Work& mine) {
          if (mine.cuts) others.cuts->take(id, *means);
          const CoarsePhoto photo(std::move(means));
          tbb::parallel_for(std::size_t{0}, mine.sides.size(),
                            [&](std::size_t i) { sample_side(*mine.sides[i].first, mine.sides[i].second, id, photo); });
          if (mine.blends) others.blend->take(id, photo, result_.edges);
          if (mine.overlaps) others.overlaps->take(id, photo);
        });
    sample_finished();
    weigh();
    return std::move(result_);
  }

 private:
  /// What a view's photo is needed for.
  struct Work {
    std::vector<std::pair<const SeamEdge*, std::size_t>> sides;
    bool blends = false, cuts = false, overlaps = false;
    bool empty() const { return sides.empty() && !blends && !cuts && !overlaps; }
  };

  void sample_side(const SeamEdge& edge, std::size_t side, ViewId id, const CoarsePhoto& photo) {
    const View& view = input_.scene.views[index(id)];
    const FaceId face{edge.faces[side]};
    const bool partial = input_.tags[index(face)] == labeling::FaceTag::partial;
    const visibility::FaceCoverage* seen = partial ? coverage_.find(face, id) : nullptr;
    if (partial && !seen) return;
    const WorldPoint &a = input_.mesh.positions[edge.vertices[0]], &b = input_.mesh.positions[edge.vertices[1]];
    for (std::uint32_t i = 0; i < edge.samples; ++i) {
      const auto p = pixel_from_world(view, a + (i + 0.5) / edge.samples * (b - a));
      if (!p) continue;
      if (seen && !shows(*seen, *p)) continue;
      const auto q = photo_from_pixel(view.camera, *p);
      if (!q || q->x < 0 || q->y < 0 || q->x > view.camera.width || q->y > view.camera.height) continue;
      const std::size_t at = edge.first_sample + i;
      result_.colors[at][side] = photo.at(*q);
      result_.frame[at][side] = *p;
      change2_[side][at] = expected_change2([&](const PhotoPoint& at_q) { return photo.at(at_q); }, *q);
    }
  }

  /// Sides that have their texture already show what it shows.
  void sample_finished() {
    tbb::parallel_for(std::size_t{0}, result_.edges.size(), [&](std::size_t e) {
      const SeamEdge& edge = result_.edges[e];
      for (std::size_t side = 0; side < 2; ++side) {
        const std::uint32_t face = edge.faces[side];
        if (!is_finished(input_, face)) continue;
        const Image& page = finished_page(input_, face);
        const auto shown = [&page](const PhotoPoint& q) { return sample_bilinear(page, q.x, q.y); };
        const TexelPoint a = finished_place(input_, face, edge.vertices[0]);
        const TexelPoint b = finished_place(input_, face, edge.vertices[1]);
        for (std::uint32_t i = 0; i < edge.samples; ++i) {
          const double t = (i + 0.5) / edge.samples;
          const PhotoPoint q{a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
          result_.colors[edge.first_sample + i][side] = shown(q);
          change2_[side][edge.first_sample + i] = expected_change2(shown, q);
        }
      }
    });
  }

  void weigh() {
    constexpr float kNoise2 = kPhotoNoise * kPhotoNoise;
    result_.weight = filled(result_.colors.size(), 0.0f);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, result_.weight.size()), [&](const auto& some) {
      for (std::size_t i = some.begin(); i < some.end(); ++i)
        if (change2_[0][i] != kNotShown && change2_[1][i] != kNotShown)
          result_.weight[i] = kNoise2 / (kNoise2 + change2_[0][i] + change2_[1][i]);
    });
  }

  bool shows(const visibility::FaceCoverage& seen, const PixelPoint& p) const {
    if (!(p.x >= seen.x0 && p.y >= seen.y0 && p.x < seen.x0 + seen.width && p.y < seen.y0 + seen.height)) return false;
    return coverage_.table().sees(seen, static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)));
  }

  const AtlasInput& input_;
  const CoverageIndex& coverage_;
  SeamSamples result_;
  static constexpr float kNotShown = -1;
  std::array<std::vector<float>, 2> change2_;  ///< expected_change2() of both sides, in squared grey levels
};

}  // namespace

std::vector<SeamEdge> find_seams(const AtlasInput& input) {
  std::vector<SeamEdge> edges;
  std::size_t count = 0;
  for (const auto& [a, b] : input.graph.edges) {
    const bool a_finished = is_finished(input, a), b_finished = is_finished(input, b);
    if (input.labels[a] == input.labels[b] ? a_finished == b_finished : a_finished && b_finished) continue;
    if (!has_view(input, a) || !has_view(input, b)) continue;
    const auto vertices = shared_edge(input.mesh.faces[a], input.mesh.faces[b]);
    if (!vertices) continue;
    SeamEdge edge{{a, b}, *vertices, count, 0};
    edge.samples = static_cast<std::uint32_t>(sample_count(input, edge));
    count += edge.samples;
    edges.push_back(edge);
  }
  return edges;
}

SeamSamples sample_seams(const AtlasInput& input, const CoverageIndex& coverage, std::vector<SeamEdge> edges,
                         const AlsoSampled& others) {
  return Sampler(input, coverage).sample(std::move(edges), others);
}

}  // namespace gpvc::atlas
