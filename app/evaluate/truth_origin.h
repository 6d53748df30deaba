// A model judged by what the photos show where its texture was taken from.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "app/evaluate/json.h"
#include "app/evaluate/truth_points.h"

namespace gpvc::evaluate {

/// Where two photos are blended, the greater of both verdicts counts.
enum class OriginVerdict : std::uint8_t { filled, right, edge, wrong };

/// Judges a place of a photo's undistorted frame; `surfaces` is the photo's id picture, row-major. Sets `place.at` and
/// `place.surface` to where that is in the photo and what it shows. A place outside the photo is wrong.
OriginVerdict origin_verdict(const Camera& camera, std::span<const std::uint32_t> surfaces, const PixelPoint& at,
                             std::uint32_t own, WrongPoint& place);

/// Shares of the points by where they take their colours from. Reads no photo.
OriginScore score_origins(const TruthInput& input, const ShownPhotos& photos, const TruthPoints& points,
                          const OriginOf& origin);

std::string origin_table(const OriginScore& score);
/// The shares as run.json and compare's report have them.
Json shares_json(const TruthShares& shares);
Json shares_json(const OriginShares& shares);

}  // namespace gpvc::evaluate
