#include "atlas/leveling/limit_offsets.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "atlas/blending/coarse_photo.h"
#include "atlas/leveling/finished_texture.h"
#include "atlas/sampling/each_photo.h"

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
  std::vector<std::span<const Sight>> work;
  for (std::uint32_t v = 0; v < views; ++v) work.push_back(sights[v]);
  const auto fetch = [&](ViewId id) { return input.photos.coarse(id); };
  each_fetched(
      work, PhotoOrder::ascending, fetch,
      [&](ViewId id, std::shared_ptr<const Image>& means, std::span<const Sight> mine) {
        const CoarsePhoto photo(std::move(means));
        const View& view = input.scene.views[index(id)];
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mine.size(), 1024), [&](const auto& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const auto [vertex, item] = mine[i];
            const BlendView& at = blending.at(vertex)[item];
            const PixelPoint frame =
                pixel_from_camera(view.camera, camera_from_world(view.pose, input.mesh.positions[vertex]));
            const Color gain = correction.gain(id, frame);
            colors[first[vertex] + item] = stored(corrected(gain * photo.at({double{at.x}, double{at.y}}), {}, gain));
          }
        });
      });
  return colors;
}

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr AddedRange kUnlimited{{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};

/// kUnlimited where `main` is not among several views at the vertex.
AddedRange range_at(const BlendWeights& blending, std::uint32_t vertex, std::uint32_t main,
                    std::span<const StoredColor> colors) {
  Color least = kUnlimited.most, most = kUnlimited.least, without_offset;
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
  if (!has_main) return kUnlimited;
  const Color room{kOffsetTolerance, kOffsetTolerance, kOffsetTolerance};
  return {least - without_offset - room, most - without_offset + room};
}

/// A corner of a face.
struct Corner {
  std::uint32_t face = 0, corner = 0;
};
constexpr std::uint32_t kNowhere = std::numeric_limits<std::uint32_t>::max();

/// Of each node one: they are of faces of one view, and have one vertex. Of kNowhere where no offset is added.
std::vector<Corner> corners_of_nodes(const AtlasInput& input, const ColorCorrection& correction) {
  std::vector<Corner> corners(correction.offsets.size(), {kNowhere, 0});
  for (std::uint32_t face = 0; face < input.mesh.faces.size(); ++face) {
    if (!has_view(input, face) || is_finished(input, face)) continue;
    for (std::uint32_t k = 0; k < 3; ++k) corners[correction.nodes[face][k]] = {face, k};
  }
  return corners;
}

/// The share of what a strip adds at a node that the range leaves beside the node's offset.
Color share_of(const AddedRange& range, const Color& offset, const Color& strip) {
  Color share{1, 1, 1};
  for (const auto channel : kChannels) {
    const float added = strip.*channel;
    const float room = added > 0 ? range.most.*channel - offset.*channel : offset.*channel - range.least.*channel;
    if (room < std::abs(added)) share.*channel = std::max(0.0f, room) / std::abs(added);
  }
  return share;
}

}  // namespace

std::vector<AddedRange> find_added_ranges(const AtlasInput& input, const BlendWeights& blending,
                                          const ColorCorrection& correction) {
  if (blending.empty() || correction.offsets.empty()) return {};
  std::vector<std::size_t> first(1, 0);
  for (std::uint32_t vertex = 0; vertex < blending.vertices(); ++vertex)
    first.push_back(first.back() + blending.at(vertex).size());
  const std::vector<StoredColor> colors = sample_colors(input, blending, correction, first);
  std::vector<AddedRange> ranges(correction.offsets.size(), kUnlimited);
  const std::vector<Corner> corners = corners_of_nodes(input, correction);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ranges.size(), 1024), [&](const auto& some) {
    for (std::size_t node = some.begin(); node < some.end(); ++node) {
      const auto [face, corner] = corners[node];
      if (face == kNowhere) continue;
      const std::uint32_t vertex = input.mesh.faces[face][corner];
      ranges[node] = range_at(blending, vertex, static_cast<std::uint32_t>(index(input.labels[face])),
                              std::span(colors).subspan(first[vertex], blending.at(vertex).size()));
    }
  });
  return ranges;
}

void limit_offsets(std::span<const AddedRange> ranges, ColorCorrection& correction) {
  for (std::size_t node = 0; node < ranges.size(); ++node) {
    for (const auto channel : kChannels) {
      float& value = correction.offsets[node].*channel;
      value = value > 0 ? std::min(value, std::max(0.0f, ranges[node].most.*channel))
                        : std::max(value, std::min(0.0f, ranges[node].least.*channel));
    }
  }
}

void limit_strips(std::span<const AddedRange> ranges, const AtlasInput& input, const ChartSet& set,
                  ColorCorrection& correction) {
  if (ranges.empty()) return;
  const Grouped<Corner> corners = group_items<Corner>(ranges.size(), [&](const auto& emit) {
    for (std::uint32_t face = 0; face < input.mesh.faces.size(); ++face) {
      if (!has_view(input, face) || is_finished(input, face) || !correction.strip(set.face_chart[face])) continue;
      for (std::uint32_t k = 0; k < 3; ++k) emit(correction.nodes[face][k], Corner{face, k});
    }
  });
  correction.strip_shares.assign(ranges.size(), {1, 1, 1});
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ranges.size(), 256), [&](const auto& some) {
    for (std::size_t node = some.begin(); node < some.end(); ++node) {
      std::uint32_t chart = std::numeric_limits<std::uint32_t>::max();
      for (const auto& [face, corner] : corners[node]) {
        // A node's corners have one place on a chart, and are mostly on one.
        if (set.face_chart[face] == chart) continue;
        chart = set.face_chart[face];
        const TexelPoint& p = set.corners[face][corner];
        const Color share =
            share_of(ranges[node], correction.offsets[node], strip_offset(correction.strip(chart), p.x, p.y));
        Color& least = correction.strip_shares[node];
        for (const auto channel : kChannels) least.*channel = std::min(least.*channel, share.*channel);
      }
    }
  });
}

}  // namespace gpvc::atlas
