#include "atlas/leveling/limit_offsets.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "atlas/blending/coarse_photo.h"
#include "atlas/leveling/finished_texture.h"

namespace gpvc::atlas {

namespace {

constexpr std::array kChannels{&Color::r, &Color::g, &Color::b};

/// A colour in 64ths of a grey level, below 1024: what is beyond white is stored as white.
using StoredColor = std::array<std::uint16_t, 3>;
constexpr float kStoredUnit = 64;

StoredColor stored(const Color& color) {
  const auto level = [](float value) {
    return static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0f, 1023.0f) * kStoredUnit));
  };
  return {level(color.r), level(color.g), level(color.b)};
}

Color loaded(const StoredColor& color) {
  return (1 / kStoredUnit) *
         Color{static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])};
}

/// A view at a vertex: where its colour is stored.
struct Sight {
  std::uint32_t vertex, item;
};

/// The exposed coarse colours of all views at all vertices, in the order of BlendWeights::at().
std::vector<StoredColor> sample_colors(const AtlasInput& input, const BlendWeights& blending,
                                       const ColorCorrection& correction, const std::vector<std::size_t>& first) {
  std::vector<StoredColor> colors(first.back());
  const std::size_t views = input.scene.views.size();
  const Grouped<Sight> sights = group_items<Sight>(views, [&](const auto& emit) {
    for (std::uint32_t vertex = 0; vertex + 1 < first.size(); ++vertex) {
      std::uint32_t item = 0;
      for (const BlendView& each : blending.at(vertex)) emit(each.view, Sight{vertex, item++});
    }
  });
  for (std::uint32_t v = 0; v < views; ++v) {
    const std::span<const Sight> mine = sights[v];
    if (mine.empty()) continue;
    const CoarsePhoto photo(input.photos.coarse(ViewId{v}));
    const View& view = input.scene.views[v];
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mine.size(), 1024), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        const auto [vertex, item] = mine[i];
        const BlendView& at = blending.at(vertex)[item];
        const PixelPoint frame =
            pixel_from_camera(view.camera, camera_from_world(view.pose, input.mesh.positions[vertex]));
        const Color gain = correction.gain(ViewId{v}, frame);
        colors[first[vertex] + item] = stored(corrected(gain * photo.at({double{at.x}, double{at.y}}), {}, gain));
      }
    });
  }
  return colors;
}

/// Within what an offset keeps a channel in the range of the photos.
struct Limits {
  Color least, most;
};

/// nullopt where `main` is not among the views at the vertex.
std::optional<Limits> limits_at(const BlendWeights& blending, std::uint32_t vertex, std::uint32_t main,
                                std::span<const StoredColor> colors) {
  constexpr float kFar = std::numeric_limits<float>::max();
  Color least{kFar, kFar, kFar}, most{-kFar, -kFar, -kFar}, without_offset;
  bool has_main = false;
  std::size_t i = 0;
  for (const BlendView& each : blending.at(vertex)) {
    const Color color = loaded(colors[i++]);
    for (const auto channel : kChannels) {
      least.*channel = std::min(least.*channel, color.*channel);
      most.*channel = std::max(most.*channel, color.*channel);
    }
    without_offset = without_offset + blending.share(vertex, each.view, main).factor * color;
    if (each.view != main) continue;
    without_offset = without_offset + color;
    has_main = true;
  }
  if (!has_main) return std::nullopt;
  const Color room{kOffsetTolerance, kOffsetTolerance, kOffsetTolerance};
  return Limits{least - without_offset - room, most - without_offset + room};
}

}  // namespace

void limit_offsets(const AtlasInput& input, const BlendWeights& blending, ColorCorrection& correction) {
  if (blending.empty() || correction.offsets.empty()) return;
  std::vector<std::size_t> first(1, 0);
  for (std::uint32_t vertex = 0; vertex < blending.vertices(); ++vertex)
    first.push_back(first.back() + blending.at(vertex).size());
  const std::vector<StoredColor> colors = sample_colors(input, blending, correction, first);
  std::vector<char> done(correction.offsets.size(), 0);
  for (std::size_t face = 0; face < input.mesh.faces.size(); ++face) {
    if (!has_view(input, face) || is_finished(input, face)) continue;
    const auto main = static_cast<std::uint32_t>(index(input.labels[face]));
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t node = correction.nodes[face][k], vertex = input.mesh.faces[face][k];
      if (done[node] != 0) continue;
      done[node] = 1;
      Color& offset = correction.offsets[node];
      if (offset.r == 0 && offset.g == 0 && offset.b == 0) continue;
      const auto limits =
          limits_at(blending, vertex, main, std::span(colors).subspan(first[vertex], blending.at(vertex).size()));
      if (!limits) continue;
      // An offset is made smaller, never larger or of the other sign: what blending does beyond the range is its own.
      for (const auto channel : kChannels) {
        float& value = offset.*channel;
        value = value > 0 ? std::min(value, std::max(0.0f, limits->most.*channel))
                          : std::max(value, std::min(0.0f, limits->least.*channel));
      }
    }
  }
}

}  // namespace gpvc::atlas
