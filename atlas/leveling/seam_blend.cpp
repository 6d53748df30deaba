#include "atlas/leveling/seam_blend.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "atlas/leveling/finished_texture.h"
#include "atlas/sampling/exposure.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

constexpr float kColorUnit = 256;

WorldPoint place_of(const AtlasInput& input, const SeamEdge& edge, std::uint32_t sample) {
  const WorldPoint &a = input.mesh.positions[edge.vertices[0]], &b = input.mesh.positions[edge.vertices[1]];
  return a + (sample + 0.5) / edge.samples * (b - a);
}

std::uint32_t label(const AtlasInput& input, std::uint32_t face) {
  return static_cast<std::uint32_t>(index(input.labels[face]));
}

}  // namespace

SeamBlend::SeamBlend(const AtlasInput& input, const BlendWeights& weights, std::span<const SeamEdge> edges)
    : input_(&input), weights_(&weights) {
  std::size_t colors = 0;
  std::vector<std::uint32_t> views;
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    const SeamEdge& edge = edges[e];
    views.clear();
    for (const std::uint32_t vertex : edge.vertices)
      for (const BlendView& item : weights.at(vertex)) views.push_back(item.view);
    std::ranges::sort(views);
    views.erase(std::unique(views.begin(), views.end()), views.end());
    for (const std::uint32_t view : views) {
      parts_.push_back({e, view, colors});
      colors += edge.samples;
    }
  }
  colors_.resize(colors);
  of_view_ = group_items<std::uint32_t>(input.scene.views.size(), [&](const auto& add) {
    for (std::uint32_t i = 0; i < parts_.size(); ++i) add(parts_[i].view, i);
  });
}

void SeamBlend::take(ViewId id, const CoarsePhoto& photo, std::span<const SeamEdge> edges) {
  const View& view = input_->scene.views[index(id)];
  const std::span<const std::uint32_t> mine = of_view_[index(id)];
  tbb::parallel_for(std::size_t{0}, mine.size(), [&](std::size_t n) {
    const Part& part = parts_[mine[n]];
    const SeamEdge& edge = edges[part.edge];
    for (std::uint32_t i = 0; i < edge.samples; ++i) {
      const auto q = photo_from_world(view, place_of(*input_, edge, i));
      if (!q) continue;
      const Color color = photo.at(*q);
      colors_[part.first + i] = {static_cast<std::uint16_t>(kColorUnit * color.r + 0.5f),
                                 static_cast<std::uint16_t>(kColorUnit * color.g + 0.5f),
                                 static_cast<std::uint16_t>(kColorUnit * color.b + 0.5f)};
    }
  });
}

void SeamBlend::add_to(SeamSamples& seams, std::span<const ViewExposure> exposure) const {
  // Parts of an edge follow each other; edges are worked on side by side.
  const Grouped<std::uint32_t> of_edge = group_items<std::uint32_t>(seams.edges.size(), [&](const auto& add) {
    for (std::uint32_t i = 0; i < parts_.size(); ++i) add(parts_[i].edge, i);
  });
  tbb::parallel_for(std::size_t{0}, seams.edges.size(), [&](std::size_t e) {
    const SeamEdge& edge = seams.edges[e];
    for (const std::uint32_t number : of_edge[e]) {
      const Part& part = parts_[number];
      const View& view = input_->scene.views[part.view];
      std::array<std::array<float, 2>, 2> factor;  // by side and end
      for (std::size_t side = 0; side < 2; ++side)
        for (std::size_t end = 0; end < 2; ++end)
          factor[side][end] =
              is_finished(*input_, edge.faces[side])
                  ? 0
                  : weights_->share(edge.vertices[end], part.view, label(*input_, edge.faces[side])).factor;
      for (std::uint32_t i = 0; i < edge.samples; ++i) {
        const auto& raw = colors_[part.first + i];
        Color color = (1 / kColorUnit) *
                      Color{static_cast<float>(raw[0]), static_cast<float>(raw[1]), static_cast<float>(raw[2])};
        if (!exposure.empty()) {
          const CameraPoint c = camera_from_world(view.pose, place_of(*input_, edge, i));
          const Color gain = gain_at(exposure[part.view], pixel_from_camera(view.camera, c));
          color = corrected(gain * color, {}, gain);
        }
        const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(edge.samples);
        for (std::size_t side = 0; side < 2; ++side) {
          Color& sum = seams.colors[edge.first_sample + i][side];
          sum = sum + (factor[side][0] * (1 - t) + factor[side][1] * t) * color;
        }
      }
    }
  });
}

}  // namespace gpvc::atlas
