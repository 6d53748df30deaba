// How well the pages of photos with bands reproduce each band.
#pragma once

#include <string>
#include <vector>

#include "app/evaluate/evaluate.h"

namespace gpvc::evaluate {

/// Scores of the bands of a model with samples beside its pages; none where the scene or the model has none. Reads the samples of all
/// pages, and each photo once a band. Throws InputError where they have other bands.
std::vector<BandScore> evaluate_bands(const Scene& scene, io::PhotoSource& photos, const io::LoadedModel& model,
                                      const EvaluateOptions& options, const Progress& progress);

Json bands_json(const std::vector<BandScore>& bands);
/// A line a band. Empty where there are none.
std::string bands_table(const std::vector<BandScore>& bands);

}  // namespace gpvc::evaluate
