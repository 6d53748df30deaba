#include "atlas/baking/color_hulls.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "io/vector.h"

namespace gpvc::atlas {

namespace {

PixelPoint frame_position(const View& view, const WorldPoint& p) {
  return pixel_from_camera(view.camera, camera_from_world(view.pose, p));
}

constexpr std::array kChannels{&Color::r, &Color::g, &Color::b};

}  // namespace

ColorHulls::ColorHulls(const AtlasBuild& build, const Chart& chart, std::span<const std::uint32_t> faces)
    : main_(chart.view) {
  for (std::size_t i = 0; i < faces.size(); i += kSampled) {
    Sample sample;
    sample.face = faces[i];
    if (build.blending.at(vertex_of(build, sample)).size() > 1) samples_.push_back(sample);
  }
}

void ColorHulls::add(const AtlasBuild& build, ViewId id, const CoarseRows& coarse) {
  const auto number = static_cast<std::uint32_t>(index(id)), main = static_cast<std::uint32_t>(index(main_));
  const View& view = build.input.scene.views[index(id)];
  for (Sample& sample : samples_) {
    const std::uint32_t vertex = vertex_of(build, sample);
    const BlendWeights::Share share = build.blending.share(vertex, number, main);
    if (share.at == nullptr) continue;
    const Color gain = build.correction.gain(id, frame_position(view, build.input.mesh.positions[vertex]));
    std::array<ColorSum, 1> at{};
    coarse.add_row({double{share.at->x}, double{share.at->y}}, {}, {{1, 1, 1}}, {{}, {}}, at);
    const Color photo = (1 / kSumUnit) *
                        Color{static_cast<float>(at[0][0]), static_cast<float>(at[0][1]), static_cast<float>(at[0][2])};
    const Color exposed = gain * photo;
    const Color shown = corrected(exposed, {}, gain);
    for (const auto channel : kChannels) {
      sample.least.*channel = std::min(sample.least.*channel, shown.*channel);
      sample.most.*channel = std::max(sample.most.*channel, shown.*channel);
    }
    sample.blended = sample.blended + share.factor * shown;
    if (id != main_) continue;
    sample.own = exposed;
    sample.has_own = true;
  }
}

InventedColor ColorHulls::count(const AtlasBuild& build, const ChartStrip* strip) const {
  InventedColor result;
  const View& view = build.input.scene.views[index(main_)];
  for (const Sample& sample : samples_) {
    if (!sample.has_own) continue;
    const TexelTriangle& t = build.set.corners[sample.face];
    const Color gain =
        build.correction.gain(main_, frame_position(view, build.input.mesh.positions[vertex_of(build, sample)]));
    const Color added = build.correction.added(sample.face, t, t[0].x, t[0].y, strip_offset(strip, t[0].x, t[0].y));
    const Color color = corrected(sample.own, added, gain) + sample.blended;
    const auto texels = static_cast<std::uint64_t>(std::lround(std::max(1.0, std::abs(doubled_area(t)) / 2)));
    result.texels += texels;
    // What is beyond white or black is stored as these, so the range is that of what can be stored, too.
    const bool is_outside = std::ranges::any_of(kChannels, [&](const auto channel) {
      const float value = std::clamp(color.*channel, 0.0f, 255.0f);
      return value < sample.least.*channel - InventedColor::kTolerance ||
             value > std::min(sample.most.*channel, 255.0f) + InventedColor::kTolerance;
    });
    if (is_outside) result.outside += texels;
  }
  return result;
}

}  // namespace gpvc::atlas
