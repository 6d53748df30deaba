// Colours of texels that are looked up one by one, through the planes of their faces.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "atlas/baking/baking.h"
#include "atlas/sampling/sampling.h"

namespace gpvc::atlas {

/// What a view shows over a texel.
struct ExposedTexel {
  Color color, gain;  ///< the former exposed
  PixelPoint frame;   ///< of the texel's middle
};

/// Looks up texels of a row, one after the other.
class TexelSampler {
 public:
  TexelSampler(const AtlasBuild& build, const ViewPhoto& photo) : build_(build), photo_(photo) {}

  /// Begins with texels first .. first + count - 1 of a source in a row, at most kStripRow; borrows the source.
  void begin(const TexelSource& source, int y, int first, int count);
  /// One bicubic sample where the texel is about as fine as the photo's pixels, else the mean of a grid of samples over its square, one
  /// for each pixel, those that do not show the face left out. In a given layout samples stay close to the face if the square takes many pixels: a texel
  /// that is larger than its face has the face's colour. nullopt where the view shows nothing.
  /// \pre the texel is one of those begun with \param samples become the means of the layers after the first
  std::optional<ExposedTexel> sample(int x, std::vector<Color>& samples);

 private:
  std::optional<ExposedTexel> one_sample(int x, std::vector<Color>& samples) const;
  std::optional<ExposedTexel> mean_of_samples(int x, std::vector<Color>& samples);
  Overshoot overshoot() const;
  /// Of one of so many rows of samples.
  const InnerRow& inner(int row, int rows);

  const AtlasBuild& build_;
  const ViewPhoto& photo_;
  const TexelSource* source_ = nullptr;
  int y_ = 0;
  bool takes_one_ = false;         ///< each texel takes one sample
  std::optional<LocalGain> gain_;  ///< of these texels, if so and if there are gains
  std::vector<InnerRow> inner_;    ///< of the rows of samples that the last texel had
};

/// Offsets of a chart's strip at texels that come in blocks of kStripRow x kStripRow, row by row.
class StripOffsets {
 public:
  /// \param strip or nullptr, for none
  StripOffsets(const ChartStrip* strip, const CellBox& box) : strip_(strip), box_(box) {}

  Color at(int x, int y);

 private:
  static constexpr int kNowhere = std::numeric_limits<int>::min();
  const ChartStrip* strip_;
  CellBox box_;
  int x0_ = kNowhere, y0_ = kNowhere;  ///< the block of near_
  int row_ = kNowhere;                 ///< the row of offsets_
  std::vector<StripSample> near_;
  std::array<Color, kStripRow> offsets_{};
};

}  // namespace gpvc::atlas
