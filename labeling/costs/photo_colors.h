// Colours of faces in photos, with the photos' gains removed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "labeling/face_record.h"

namespace gpvc::labeling {

class PhotoColors {
 public:
  /// \param log2_gain per view and channel, the logarithm to base 2 of the factor that colours are divided by; views beyond its
  /// end, up to `views`, have none
  PhotoColors(std::span<const double> log2_gain, std::size_t views)
      : log2_gain_(std::max(3 * views, log2_gain.size()), 0.0), scale_(log2_gain_.size(), kUnit) {
    for (std::size_t i = 0; i < log2_gain.size(); ++i) set(i, log2_gain[i]);
  }
  const std::vector<double>& log2_gain() const { return log2_gain_; }
  void set(std::size_t i, double log2_gain) {
    log2_gain_[i] = log2_gain;
    scale_[i] = std::exp2(-log2_gain) * kUnit;
  }
  float level(std::uint32_t view, const FaceRecord& record, std::size_t channel) const {
    return static_cast<float>(record.color[channel] * scale_[std::size_t{view} * 3 + channel]);
  }
  std::array<float, 3> rgb(std::uint32_t view, const FaceRecord& record) const {
    return {level(view, record, 0), level(view, record, 1), level(view, record, 2)};
  }

 private:
  static constexpr double kUnit = 1.0 / 256;  ///< of FaceRecord::color, in grey levels
  std::vector<double> log2_gain_;
  std::vector<double> scale_;  ///< kUnit / gain, for colours
};

}  // namespace gpvc::labeling
