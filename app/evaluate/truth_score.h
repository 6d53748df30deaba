// Scores of textured models of a synthetic scene: by the colours they show, and by where these come from.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "app/evaluate/json.h"
#include "app/evaluate/truth_points.h"

namespace gpvc::evaluate {

/// Sample points on every face and what the used photos show there. To be made once for any number of models.
class TruthScorer {
 public:
  /// Throws InputError from photos and id pictures, and when the meshes have different numbers of faces. Takes a few
  /// bytes for each point and used view. What a photo's mask excludes counts as not seen, and as no error.
  /// Progress counts views, each of which is gone through three times: by the oracle, and twice as a photo.
  TruthScorer(const TruthInput& input, const Progress& progress);

  /// O(points x views), TBB; reads every photo once.
  TruthScore score(const MatchedModel& model, const Progress& progress) const;
  /// O(points), TBB; reads no photo.
  OriginScore score(const OriginOf& origin) const;

 private:
  TruthInput input_;
  ShownPhotos photos_;
  TruthPoints points_;
};

/// `texels`: of a model at the seen points. O(points).
TruthLight light_of(const Mesh& mesh, const TruthPoints& points, std::span<const std::optional<Pixel>> texels);

/// Where two photos are blended, the greater of both verdicts counts.
enum class OriginVerdict : std::uint8_t { filled, right, edge, wrong };

/// Judges a place of a photo's undistorted frame; `surfaces` is the photo's id picture, row-major. Sets `place.at` and
/// `place.surface` to where that is in the photo and what it shows. A place outside the photo is wrong.
OriginVerdict origin_verdict(const Camera& camera, std::span<const std::uint32_t> surfaces, const PixelPoint& at,
                             std::uint32_t own, WrongPoint& place);

/// A table for people; `origins` may be nullptr.
std::string truth_table(const TruthScore& score, const OriginScore* origins);
/// The shares as run.json and compare's report have them.
Json shares_json(const TruthShares& shares);
Json shares_json(const OriginShares& shares);
Json light_json(const TruthLight& light);

}  // namespace gpvc::evaluate
