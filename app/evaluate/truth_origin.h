// What lies where a texture took its colours from.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "app/evaluate/json.h"
#include "app/evaluate/truth.h"

namespace gpvc::evaluate {

/// In the order in which the worse of two counts.
enum class OriginVerdict : std::uint8_t { filled, right, edge, wrong };

/// What a photo shows at a place of its undistorted frame; `surfaces` is its id picture, row-major. Where it is wrong,
/// `place` is told where in the photo and what is there. A place outside the photo is wrong.
OriginVerdict origin_verdict(const Camera& camera, std::span<const std::uint32_t> surfaces, const PixelPoint& at,
                             std::uint32_t own, WrongPoint& place);

/// Adds a point's area to the sums that make_shares() divides.
void add_origin(OriginVerdict verdict, double area, OriginShares& sums);
/// The same for a point that no photo sees.
void add_hidden_origin(OriginVerdict verdict, double area, OriginShares& sums);
void make_shares(OriginShares& sums);

std::string origin_table(const OriginScore& score);
/// The shares as run.json, evaluate's and compare's reports have them.
Json shares_json(const TruthShares& shares);
Json shares_json(const OriginShares& shares);

}  // namespace gpvc::evaluate
