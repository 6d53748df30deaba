// The correction that seam leveling applies to a photo's colour.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/charts/charts.h"
#include "atlas/leveling/seam_strips.h"
#include "atlas/sampling/exposure.h"
#include "io/image.h"

namespace gpvc::atlas {

/// ColorCorrection::face_offset for positions inside the face.
class OffsetPlane {
 public:
  OffsetPlane() = default;
  OffsetPlane(const TexelTriangle& corners, const std::array<Color, 3>& offsets);
  Color at(double x, double y) const {
    const double u = x - corner_.x, v = y - corner_.y;
    return {channels_[0].at(u, v), channels_[1].at(u, v), channels_[2].at(u, v)};
  }

 private:
  struct Channel {
    double at_corner = 0, dx = 0, dy = 0;
    float least = 0, most = 0;  ///< of the corners: rounding in a narrow face must not leave this range
    float at(double u, double v) const {
      return std::clamp(static_cast<float>(at_corner + u * dx + v * dy), least, most);
    }
  };
  TexelPoint corner_;
  std::array<Channel, 3> channels_;
};

struct ColorCorrection {
  std::vector<ViewExposure> exposure;               ///< per view; empty: colours keep their exposure
  std::vector<std::array<std::uint32_t, 3>> nodes;  ///< per face and corner, into offsets; empty: no offsets
  std::vector<Color> offsets;
  std::vector<ChartStrip> strips;   ///< per chart; empty: no strips
  std::vector<Color> strip_shares;  ///< per node, of the strip's offset that is added there, 0 to 1; empty: all of it

  Color gain(ViewId view, const PixelPoint& frame) const {
    return exposure.empty() ? Color{1, 1, 1} : gain_at(exposure[index(view)], frame);
  }
  /// Offset of a face at a position in its chart's texels. Outside the face it is that of a place on the face's border.
  Color face_offset(std::uint32_t face, const TexelTriangle& corners, double x, double y) const;
  OffsetPlane offset_plane(std::uint32_t face, const TexelTriangle& corners) const {
    return {corners, {offsets[nodes[face][0]], offsets[nodes[face][1]], offsets[nodes[face][2]]}};
  }
  /// True if less than all of a strip's offsets is added to a part of the face.
  bool limits_strip(std::uint32_t face) const;
  /// As offset_plane(), of the share of a strip's offsets. \pre limits_strip(face)
  OffsetPlane strip_plane(std::uint32_t face, const TexelTriangle& corners) const {
    return {corners, {strip_shares[nodes[face][0]], strip_shares[nodes[face][1]], strip_shares[nodes[face][2]]}};
  }
  /// What a face takes of an offset of its chart's strip.
  Color taken(const Color& strip, std::uint32_t face, const TexelTriangle& corners, double x, double y) const;
  /// What is added to the exposed colours of a face.
  Color added(std::uint32_t face, const TexelTriangle& corners, double x, double y, const Color& strip) const {
    return face_offset(face, corners, x, y) + taken(strip, face, corners, x, y);
  }
  const ChartStrip* strip(std::uint32_t chart) const {
    return strips.empty() || strips[chart].empty() ? nullptr : &strips[chart];
  }
};
GPVC_MEMBERS(ColorCorrection, exposure, nodes, offsets, strips, strip_shares)
/// True if leveling may have found it for these charts: numbers that are numbers, of views, faces, nodes and cells that are there.
bool is_sound(const ColorCorrection& correction, const AtlasInput& input, const ChartSet& set);

}  // namespace gpvc::atlas
