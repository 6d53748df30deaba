// The correction that seam leveling applies to a photo's colour.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/sampling.h"
#include "atlas/charts/charts.h"
#include "io/image.h"

namespace gpvc::atlas {

/// A place on a seam, in the texels of one of its charts, and the step that brings this side halfway to the other, or to a
/// finished one.
struct SeamStep {
  float x = 0, y = 0;
  float weight = 1;  ///< as in SeamSamples
  Color step;
};

/// One place on a seam, or several beside each other, as strips weigh them: offsets are means of `pull` over means of
/// `weight`.
struct StripSample {
  float x = 0, y = 0;
  float weight = 0;
  Color pull;
};
GPVC_MEMBERS(StripSample, x, y, weight, pull)

/// Seam samples of a chart, grouped by square cells of kStripCell texels, row-major.
struct ChartStrip {
  int columns = 0, rows = 0;
  Grouped<StripSample> cells;
  bool empty() const { return cells.items.empty(); }
};
GPVC_MEMBERS(ChartStrip, columns, rows, cells)

inline constexpr int kStripCell = 16;
/// Distance from the seam, in texels, at which its step has faded to zero.
inline constexpr float kStripWidth = 20;

/// True if the sample is close enough to the chart to change texels of it.
bool strip_reaches(const Chart& chart, const SeamStep& sample);

/// Groups a chart's samples by cells.
ChartStrip make_strip(const Chart& chart, std::span<const SeamStep> samples);

/// Replaces `near` by the strip's samples that have weight in a box of texels, those far from it for their closeness to
/// each other as one; by none if the box lies outside the strip, or without a strip (nullptr).
void gather_strip(const ChartStrip* strip, const CellBox& box, std::vector<StripSample>& near);

/// Texels whose strip offsets are computed together.
inline constexpr int kStripRow = 8;

/// Offsets at positions (x + i, y), 0 <= i < kStripRow: the harmonic continuation of the steps along the seam, faded
/// out over kStripWidth. For a straight seam the weights 1 / distance^2 are the Poisson kernel of the half-plane:
/// variations that are fine along the seam stay close to it, so no streaks run into the chart.
std::array<Color, kStripRow> strip_offsets(std::span<const StripSample> near, double x, double y);

/// The offset of a chart's strip, if it has one, at one position.
Color strip_offset(const ChartStrip* strip, double x, double y);

/// The most that a channel's gain, and what undoes the fall-off of the lens, multiply a colour by; the least are 1 / these.
/// Light falls with the fourth power of the cosine of the angle to the lens's axis: to a quarter at 45 degrees, in the
/// corner of a photo with a field of view of 90. A fit that asks for more has mostly continued its polynomial beyond the
/// radii of its seams; of a wider lens the rest of the fall-off stays.
inline constexpr double kMostGain = 2.5, kMostFallOff = 4;
inline const double kMostFallOffLog = std::log(kMostFallOff);

/// Limits the logarithm of what undoes a fall-off, wherever a frame reaches. NaN, of coefficients whose terms overflow,
/// becomes the upper limit.
inline double limited_falloff(double log) { return std::max(-kMostFallOffLog, std::min(kMostFallOffLog, log)); }

/// What the exposure multiplies a colour at a position of the view's frame by: at most kMostGain kMostFallOff.
/// \pre is_sound(exposure)
Color gain_at(const ViewExposure& exposure, const PixelPoint& frame);

/// The corrected colour of a texel. `exposed` is `gain` times the photo's colour, `added` the offset and the strip. The sum has two
/// limits:
/// - Tint. Offsets close the step between two photos; where these show different things, they would make a colour that no photo has,
///   such as blue leaves. So the factor by which a channel changes is kept within 1.25 times the mean factor of the three, and that
///   within kMostGain.
/// - Highlights, see with_highlights().
Color corrected(const Color& exposed, const Color& added, const Color& gain);
/// Grey levels from which on a channel is a highlight.
inline constexpr float kHighlight = 200;
/// Channel values above kHighlight are compressed if the gain is above 1, so that only what is 255 in the photo becomes 255.
float with_highlights(float exposed, float gain);

/// gain_at in the neighbourhood of a position, without an exponential for each place. Where the fall-off changes the
/// gain by less than a tenth, the error is below a five-thousandth of it (the third power of a tenth, over 3!).
class LocalGain {
 public:
  LocalGain(const ViewExposure& exposure, const PixelPoint& middle);
  Color at(const PixelPoint& frame) const {
    const double change = falloff(frame) - middle_;
    return static_cast<float>(1 + change * (1 + change / 2)) * gain_;
  }

 private:
  double falloff(const PixelPoint& frame) const {
    const double dx = frame.x - exposure_.centre_x, dy = frame.y - exposure_.centre_y;
    const double r2 = (dx * dx + dy * dy) * exposure_.inverse_radius2;
    return limited_falloff(r2 * (exposure_.k1 + exposure_.k2 * r2));
  }
  ViewExposure exposure_;
  double middle_;  ///< logarithm of the gain there, without the view's own
  Color gain_;     ///< in the middle
};

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
