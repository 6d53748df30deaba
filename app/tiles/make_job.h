// Cuts a scene into a job.
#pragma once

#include <string>

#include "app/pipeline/pipeline.h"
#include "app/tiles/job.h"
#include "app/tiles/plan.h"

namespace gpvc::tiles {

/// Of a job, each of whose units should run on a usual machine: some 1.5 GB.
inline constexpr std::size_t kDefaultTileFaces = 1000000;

/// The job of an input, without files and without what they are written with. O(faces log faces + faces x border).
Job cut_scene(const checks::Input& input, const JobSettings& settings, results::Observer& observer);

/// Writes mesh/ and plan.json. Throws InputError, OutputError.
std::vector<Unit> make_job(const JobFolder& folder, const checks::Input& input, const JobSettings& settings,
                           const std::string& program, results::Observer& observer);

}  // namespace gpvc::tiles
