#include "atlas/leveling/color_correction.h"

#include <algorithm>
#include <cmath>

namespace gpvc::atlas {

OffsetPlane::OffsetPlane(const TexelTriangle& t, const std::array<Color, 3>& offsets) : corner_(t[0]) {
  const double ux = t[1].x - t[0].x, uy = t[1].y - t[0].y, vx = t[2].x - t[0].x, vy = t[2].y - t[0].y;
  const double area = ux * vy - uy * vx, inverse = area == 0 ? 0 : 1 / area;
  std::size_t k = 0;
  for (const auto channel : {&Color::r, &Color::g, &Color::b}) {
    const float a = offsets[0].*channel, b = offsets[1].*channel, c = offsets[2].*channel;
    const double to_b = double{b} - double{a}, to_c = double{c} - double{a};
    channels_[k++] = {double{a}, (to_b * vy - to_c * uy) * inverse, (to_c * ux - to_b * vx) * inverse,
                      std::min({a, b, c}), std::max({a, b, c})};
  }
}

namespace {

/// At a position in a face's texels, of what its corners have.
Color between(const std::array<Color, 3>& at, const TexelTriangle& t, double x, double y) {
  if (doubled_area(t) == 0) return (1.0f / 3) * (at[0] + at[1] + at[2]);
  const std::array<double, 3> share = shares_at(t, x, y);
  return static_cast<float>(share[0]) * at[0] + static_cast<float>(share[1]) * at[1] +
         static_cast<float>(share[2]) * at[2];
}

}  // namespace

Color ColorCorrection::face_offset(std::uint32_t face, const TexelTriangle& t, double x, double y) const {
  if (nodes.empty()) return {};
  return between({offsets[nodes[face][0]], offsets[nodes[face][1]], offsets[nodes[face][2]]}, t, x, y);
}

bool ColorCorrection::limits_strip(std::uint32_t face) const {
  return !strip_shares.empty() && std::ranges::any_of(nodes[face], [&](std::uint32_t node) {
    const Color& share = strip_shares[node];
    return share.r < 1 || share.g < 1 || share.b < 1;
  });
}

Color ColorCorrection::taken(const Color& strip, std::uint32_t face, const TexelTriangle& t, double x, double y) const {
  if (!limits_strip(face)) return strip;
  return between({strip_shares[nodes[face][0]], strip_shares[nodes[face][1]], strip_shares[nodes[face][2]]}, t, x, y) *
         strip;
}

namespace {

bool is_finite(const Color& color) {
  return std::isfinite(color.r) && std::isfinite(color.g) && std::isfinite(color.b);
}

// The cells of make_strip().
bool is_sound(const ChartStrip& strip, const Chart& chart) {
  if (strip.empty()) return true;
  const std::vector<std::size_t>& first = strip.cells.first;
  return strip.columns == chart.width / kStripCell + 1 && strip.rows == chart.height / kStripCell + 1 &&
         first.size() == pixel_index(0, strip.rows, strip.columns) + 1 && std::ranges::is_sorted(first) &&
         first.back() <= strip.cells.items.size() && std::ranges::all_of(strip.cells.items, [](const StripSample& s) {
           return std::isfinite(s.x) && std::isfinite(s.y) && std::isfinite(s.weight) && s.weight > 0 &&
                  is_finite(s.pull);
         });
}

}  // namespace

bool is_sound(const ColorCorrection& correction, const AtlasInput& input, const ChartSet& set) {
  const auto is_node = [&](std::uint32_t node) { return node < correction.offsets.size(); };
  for (std::size_t c = 0; c < correction.strips.size(); ++c)
    if (c >= set.charts.size() || !is_sound(correction.strips[c], set.charts[c])) return false;
  const auto fits = [](const auto& list, std::size_t size) { return list.empty() || list.size() == size; };
  return fits(correction.exposure, input.scene.views.size()) && fits(correction.nodes, input.mesh.faces.size()) &&
         fits(correction.strips, set.charts.size()) && fits(correction.strip_shares, correction.offsets.size()) &&
         std::ranges::all_of(correction.strip_shares, is_finite) &&
         std::ranges::all_of(correction.offsets, is_finite) &&
         std::ranges::all_of(correction.exposure, [](const ViewExposure& each) { return is_sound(each); }) &&
         std::ranges::all_of(correction.nodes,
                             [&](const auto& of_face) { return std::ranges::all_of(of_face, is_node); });
}

}  // namespace gpvc::atlas
