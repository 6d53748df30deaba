// Answers about points in words and as JSON.
#pragma once

#include <string>

#include "app/evaluate/json.h"
#include "app/query/photos.h"

namespace gpvc::query {

/// What makes a candidate worse than the best view of its face, with its share of the cost: "lower quality 0.02, along a
/// silhouette 0.8"; "nothing" of the best. Empty for other photos.
std::string cost_words(const PhotoOfPoint& photo);

/// Why a photo does not show the point: words_of(), with the face that hides it.
std::string reason_words(const PhotoOfPoint& photo);

/// One photo. README's table of app/query states the members. \param judged whether silhouettes and outliers are known
evaluate::Json photo_json(const Scene& scene, const PhotoOfPoint& photo, bool judged);

/// All photos of a point, and how many show it.
evaluate::Json photos_json(const Scene& scene, const PointAnswer& answer, bool judged);

}  // namespace gpvc::query
