// Keys of what a run makes: hashes of all that each part came from.
#pragma once

#include <array>
#include <map>
#include <optional>

#include "../../io/work_store.h"
#include "run.h"

namespace gpvc::pipeline {

/// The parts of a run that are kept on disk.
struct StepKeys {
  std::map<ViewId, io::WorkKey> views;  ///< what a view sees
  io::WorkKey labels, pages;
};
/// nullopt where the photos have no keys, or this program cannot be read. O(bytes of mesh and photos), TBB. Throws InputError.
std::optional<StepKeys> step_keys(const Run& run);

/// What a result came from, part by part, so that it can be told which of them is another one.
struct ResultKeys {
  io::WorkKey mesh, views,
      options;  ///< the views with their photos; all options but view_rules and the form of the models
};
GPVC_MEMBERS(ResultKeys, mesh, views, options)
/// O(bytes of mesh and photos), TBB. Photos without keys count as the same. Throws InputError.
ResultKeys result_keys(const Run& run);

}  // namespace gpvc::pipeline
